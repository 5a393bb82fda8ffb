"""`makeup-video bench`: what the product costs beside the bare codec, in one run."""

import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from makeup_video.cli.ending import told_in_one_line
from makeup_video.cli.say import put

if TYPE_CHECKING:
    from makeup_video.cli.measure import Bench
    from makeup_video.pipeline import Look

_SAMPLES = Path(__file__).resolve().parent.parent / "samples"
_PAINTED_ROUNDS, _PAINTED_FRAMES = 3, 120  # enough for a median
_LARGER_FROM_PX = 1080  # three times as high are 8 megapixels a plane and more
_SHORT = "painted.mkv"  # so many frames of the film


def bench(
    clip: Annotated[
        str | None, typer.Argument(metavar="CLIP", help="A video; default: our sample.")
    ] = None,
    sizes: Annotated[str, typer.Option(help="Heights to scale it to.")] = "720p,1080p",
    seconds: Annotated[
        float, typer.Option(help="Length of the film; it is played to and fro until then.")
    ] = 20.0,
    rounds: Annotated[int, typer.Option(help="How often each is run; medians count.")] = 5,
    look: Annotated[
        str | None, typer.Option(metavar="FILE", help="The look that is painted (JSON).")
    ] = None,
    ref: Annotated[
        str | None, typer.Option(metavar="PHOTO", help="Or a photo of it; default: our sample.")
    ] = None,
    as_is: Annotated[
        bool,
        typer.Option("--as-is", help="Only scale CLIP, don't bring its face to half the height."),
    ] = False,
    faces: Annotated[bool, typer.Option("--faces", help="Also 1, 2, 4 and 8 faces.")] = False,
    threads: Annotated[bool, typer.Option("--threads", help="Also other threads.")] = False,
    length: Annotated[
        float, typer.Option("--length", metavar="MINUTES", help="Also a film so long.")
    ] = 0.0,
    live: Annotated[
        bool, typer.Option("--live", help="Only the live run: how late its pictures reach a page.")
    ] = False,
    renderer: Annotated[
        bool, typer.Option(help="Measure what painting costs by itself, and the floor.")
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    plot: Annotated[
        str | None, typer.Option(metavar="PNG", help="Draw it: needs makeup-video[plot].")
    ] = None,
) -> None:
    """Measure the product beside a bare decode-and-encode loop: speed, CPU, memory, start."""
    from makeup_video.cli.progress import show_steps
    from makeup_video.pipeline import UsageError

    with told_in_one_line():
        heights = heights_of(sizes)
        _check(seconds, rounds, length)
        if live and (faces or threads or plot is not None):
            raise UsageError("--live is measured alone: leave out --faces, --threads and --plot")
        if plot is not None:
            from makeup_video.cli.bench_plot import check_place, draw

            check_place(plot)
        with (
            tempfile.TemporaryDirectory(prefix="makeup-video-bench-") as name,
            show_steps() as told,
        ):
            from makeup_video.cli.measure import Bench

            source = _source(clip)
            told("reading the look")
            worn, photo = _look(look, ref)
            made = Bench(source, Path(name), worn, seconds, rounds, as_is, told, photo)
            if live:
                from makeup_video.cli.measure_live import measure_live

                results = {"live": measure_live(made, heights, length)}
            else:
                results = measure(made, heights, renderer=renderer)
                results |= more(made, heights[0], faces=faces, threads=threads, minutes=length)
        if plot is not None:
            draw(results, Path(plot))
        if as_json:
            put(json.dumps(results, indent=2) + "\n")
            return
    from makeup_video.cli.bench_tables import print_tables

    print_tables(results)


def heights_of(sizes: str) -> list[int]:
    """Of "720p,1080p". Raises UsageError."""
    from makeup_video.pipeline import UsageError

    parts = [part.removesuffix("p") for part in sizes.split(",")]
    heights = [int(part) for part in parts if part.isascii() and part.isdecimal() and len(part) < 5]
    if len(heights) != len(parts) or any(not 2 <= h <= 4320 or h % 2 for h in heights):
        raise UsageError(f"--sizes must be even heights such as 720p,1080p, got {sizes!r}")
    return heights


def _check(seconds: float, rounds: int, minutes: float) -> None:
    from makeup_video.pipeline import UsageError

    if not (0.5 <= seconds <= 3600 and rounds >= 1):
        raise UsageError(
            f"--seconds must be 0.5 to 3600 and --rounds at least 1, got {seconds:g} and {rounds}"
        )
    if not 0 <= minutes <= 600:
        raise UsageError(f"--length must be 0 to 600 minutes, got {minutes:g}")


def _source(clip: str | None) -> Path:
    from makeup_video.pipeline import InputError

    source = Path(clip) if clip else _SAMPLES / "in.mp4"
    if clip is None and not source.exists():
        raise InputError(f"the sample {source} is not installed: give a CLIP to measure with")
    return source


def _look(look: str | None, ref: str | None) -> "tuple[Look, Path | None]":
    """The look to paint, lips and eyes, and the photo that it was read from: our sample, but where that
    is not installed."""
    from makeup_video.pipeline import Look, UsageError, look_from_photo, product

    if look is not None and ref is not None:
        raise UsageError("--look and --ref both give a look: leave one of them out")
    if look is not None:
        return Look.load(look), None
    photo = Path(ref) if ref is not None else _SAMPLES / "look.jpg"
    if ref is None and not photo.exists():
        return Look(product((150, 30, 70), "satin"), product((60, 80, 150), "satin", "eyes")), None
    return look_from_photo(photo), photo


def measure(bench: "Bench", heights: list[int], *, renderer: bool) -> dict[str, Any]:
    """What every run of the command measures, by size."""
    from makeup_video.cli.measure import compare, own_process
    from makeup_video.cli.measure_clip import CODEC, CRF, PRESET

    results: dict[str, Any] = {
        "clip": bench.source.name,
        "codec": f"{CODEC} {PRESET} crf {CRF}",
        "look": bench.look.to_dict(),
        "rounds": bench.rounds,
        "sizes": {},
    }
    for at, height in enumerate(heights):
        name = f"{height}p"
        film = bench.clip(height)
        row = compare(bench, film, name) | own_process(bench, film, name)
        if renderer:
            row |= _painting(bench, film.path, name, row["product"]["not_codec_cpu_ms"])
            if at == 0 and height <= _LARGER_FROM_PX:
                results["larger_frame_ratio"] = _larger(bench)
        results["sizes"][name] = row
    return results


def _painting(bench: "Bench", film: Path, name: str, measured_ms: float) -> dict[str, Any]:
    """The renderer by itself with a look that has everything, and the floor of the one that is painted."""
    from makeup_video.cli.measure_clip import first_frames
    from makeup_video.cli.measure_floor import floor_of
    from makeup_video.cli.measure_renderer import find_in, kernel_alone, paint_costs

    bench.told(f"{name}: painting by itself")
    short = bench.folder / _SHORT
    first_frames(film, short, _PAINTED_FRAMES)
    costs = paint_costs(short, min(bench.rounds, _PAINTED_ROUNDS))
    bench.told(f"{name}: the floor")
    kernel = kernel_alone(short, find_in(short), bench.look)
    floor = floor_of(short, bench.folder, round(kernel["painted_px"]))
    return {"renderer": costs, "floor": floor, "times_the_floor": measured_ms / floor["least_ms"]}


def _larger(bench: "Bench") -> float:
    from makeup_video.cli.measure_clip import first_frames
    from makeup_video.cli.measure_renderer import larger_frame_ratio

    bench.told("the same face in a larger frame")
    short = bench.folder / "shorter.mkv"
    first_frames(bench.folder / _SHORT, short, _PAINTED_FRAMES // 2)
    return larger_frame_ratio(short, bench.folder, min(bench.rounds, _PAINTED_ROUNDS))


def more(
    bench: "Bench", height_px: int, *, faces: bool, threads: bool, minutes: float
) -> dict[str, Any]:
    """What takes its time, and is measured when it is asked for, at one size."""
    from makeup_video.cli.measure import by_faces, by_threads, over_length

    results: dict[str, Any] = {}
    if faces:
        results["faces"] = by_faces(bench, height_px)
    if threads:
        film = bench.clip(height_px)
        results["threads"] = {"size": f"{height_px}p", **by_threads(bench, film, "threads")}
    if minutes:
        results["length"] = {"size": f"{height_px}p", **over_length(bench, height_px, minutes)}
    return results
