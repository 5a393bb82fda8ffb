"""What `makeup-video bench` measures, in order."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from makeup_video.benchmark.harness import Bench
    from makeup_video.pipeline import Look

_SAMPLES = Path(__file__).resolve().parent.parent / "samples"
_PAINTED_ROUNDS, _PAINTED_FRAMES = 3, 120  # enough for a median
_LARGER_FROM_PX = 1080  # three times as high are 8 megapixels a plane and more
_SHORT = "painted.mkv"  # so many frames of the film


def sample_clip(clip: str | None) -> Path:
    from makeup_video.pipeline import InputError

    source = Path(clip) if clip else _SAMPLES / "in.mp4"
    if clip is None and not source.exists():
        raise InputError(f"the sample {source} is not installed: give a CLIP to measure with")
    return source


def sample_look(look: str | None, ref: str | None) -> "tuple[Look, Path | None]":
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
    from makeup_video.benchmark.film_costs import compare, own_process
    from makeup_video.benchmark.films import CODEC, CRF, PRESET

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
    from makeup_video.benchmark.films import first_frames
    from makeup_video.benchmark.floor import floor_of
    from makeup_video.benchmark.renderer import find_in, kernel_alone, paint_costs

    bench.told(f"{name}: painting by itself")
    short = bench.folder / _SHORT
    first_frames(film, short, _PAINTED_FRAMES)
    costs = paint_costs(short, min(bench.rounds, _PAINTED_ROUNDS))
    bench.told(f"{name}: the floor")
    kernel = kernel_alone(short, find_in(short), bench.look)
    floor = floor_of(short, bench.folder, round(kernel["painted_px"]))
    return {"renderer": costs, "floor": floor, "times_the_floor": measured_ms / floor["least_ms"]}


def _larger(bench: "Bench") -> float:
    from makeup_video.benchmark.films import first_frames
    from makeup_video.benchmark.renderer import larger_frame_ratio

    bench.told("the same face in a larger frame")
    short = bench.folder / "shorter.mkv"
    first_frames(bench.folder / _SHORT, short, _PAINTED_FRAMES // 2)
    return larger_frame_ratio(short, bench.folder, min(bench.rounds, _PAINTED_ROUNDS))


def more(
    bench: "Bench", height_px: int, *, faces: bool, threads: bool, minutes: float
) -> dict[str, Any]:
    """What takes its time, and is measured when it is asked for, at one size."""
    from makeup_video.benchmark.scaling import by_faces, by_threads, over_length

    results: dict[str, Any] = {}
    if faces:
        results["faces"] = by_faces(bench, height_px)
    if threads:
        film = bench.clip(height_px)
        results["threads"] = {"size": f"{height_px}p", **by_threads(bench, film, "threads")}
    if minutes:
        results["length"] = {"size": f"{height_px}p", **over_length(bench, height_px, minutes)}
    return results
