"""Measure the product's speed and write the tables and plots of docs/measurements.md.

    python docs/make/make_performance.py --clip talk.mp4 --hour --peer peer/bin/python

The measurements take most of an hour, or two hours with --hour, on an idle machine. --parts
measures some parts only (--parts faces length). The file --results keeps the results of all parts,
and the script writes the page from that file. The text outside the markers stays. The summary
tables of docs/performance.md repeat some of the figures: update them by hand. The script needs the
extra `plot`.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import performance_page as page
from makeup_video.benchmark.harness import Bench, beside, in_turn, middle, own_threads
from makeup_video.benchmark.runs import Run, run_bare, run_product
from makeup_video.benchmark.scaling import by_faces, by_threads, over_length
from makeup_video.benchmark.suite import heights_of, measure
from makeup_video.pipeline import look_from_photo

SAMPLES = page.DOCS.parent / "samples"
LENGTHS_MINUTES, AN_HOUR = (1 / 6, 1, 10), 60


class Measurements:
    """The measurements behind the page. Each part has a method of the same name."""

    def __init__(self, options: argparse.Namespace, folder: Path) -> None:
        self.options, self.folder = options, folder
        self.look = look_from_photo(SAMPLES / "look.jpg")

    def bench(self, clip: Path | None = None, seconds: float | None = None) -> Bench:
        options = self.options
        return Bench(
            clip or SAMPLES / "in.mp4", self.folder, self.look,
            seconds=seconds or options.seconds, rounds=options.rounds,
            log=log, photo=SAMPLES / "look.jpg",
        )  # fmt: skip

    def whole(self) -> dict[str, Any]:
        """Return the results of `makeup-video bench` by clip."""
        heights = heights_of(self.options.sizes)
        clips = [SAMPLES / "in.mp4", *self.options.clip]
        return {clip.name: measure(self.bench(clip), heights, renderer=True) for clip in clips}

    def resolution(self) -> dict[str, Any]:
        """Run the bare loop and the product in turn at every height."""
        bench, rows = self.bench(), {}
        target = self.folder / "out.mp4"
        for height in heights_of(self.options.resolutions):
            video = bench.video(height, self.options.seconds / 2)
            work: dict[str, Callable[[], Run]] = {
                "bare": partial(run_bare, video.path, target, own_threads(video)),
                "product": lambda video=video: run_product(video.path, target, self.look)[0],
            }
            runs = in_turn(bench, f"{height}p", work, bench.rounds)
            bare, product = runs["bare"], runs["product"]
            rows[f"{height}p"] = {
                "px": video.size_wh[0] * video.size_wh[1],
                "bare": middle(bare),
                "product": {**middle(product), **beside(product, bare)},
            }
        return {"heights": rows}

    def faces(self) -> dict[str, Any]:
        return by_faces(self.bench(), 1080)

    def threads(self) -> dict[str, Any]:
        bench = self.bench()
        return {"size": "720p", **by_threads(bench, bench.video(720), "threads")}

    def length(self) -> list[dict[str, Any]]:
        minutes = [*LENGTHS_MINUTES, *([AN_HOUR] if self.options.hour else [])]
        return [over_length(self.bench(), self.options.long_height, m) for m in minutes]

    def peer(self) -> str:
        """Return the output of peer_mediapipe.py, run in its own environment."""
        product = Path(sys.executable).with_name("makeup-video")
        words = [
            self.options.peer,
            Path(__file__).with_name("peer_mediapipe.py"),
            "--product",
            product,
        ]
        done = subprocess.run([str(word) for word in words], check=True, capture_output=True)
        return done.stdout.decode()


def log(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--parts",
        nargs="*",
        choices=page.PARTS,
        help="parts to measure; default: all; with no names, only write the page",
    )
    parser.add_argument(
        "--clip", type=Path, nargs="*", default=[], help="clips to measure besides samples/in.mp4"
    )
    parser.add_argument("--sizes", default="720p,1080p,2160p")
    parser.add_argument("--resolutions", default="360p,540p,720p,1080p,1440p,2160p")
    parser.add_argument("--seconds", type=float, default=20, help="length of the videos")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--long-height", type=int, default=360, help="height of the long videos")
    parser.add_argument("--hour", action="store_true", help="also measure a video of an hour")
    parser.add_argument("--peer", type=Path, help="Python of the peer's environment")
    parser.add_argument(
        "--results", type=Path, default=Path("runs/performance.json"), help="JSON of all results"
    )
    parser.add_argument("--page", type=Path, default=page.PAGE)
    parser.add_argument("--pictures", type=Path, default=page.FOLDER)
    return parser.parse_args()


def main() -> None:
    options = parse_arguments()
    measured = json.loads(options.results.read_text()) if options.results.exists() else {}
    parts = page.PARTS if options.parts is None else options.parts
    options.results.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        measurements = Measurements(options, Path(name))
        for part in parts:
            if part == "peer" and options.peer is None:
                log("the peer is not measured: it needs --peer PYTHON")
                continue
            measured[part] = getattr(measurements, part)()
            options.results.write_text(json.dumps(measured, indent=1), encoding="utf-8")
    page.write_page(measured, options.page, options.pictures)
    log(f"wrote {options.page}")


if __name__ == "__main__":
    main()
