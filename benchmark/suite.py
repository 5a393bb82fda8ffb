"""What `makeup-video bench` measures, in order."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from makeup_video.benchmark.against import Version
    from makeup_video.benchmark.harness import Bench
    from makeup_video.pipeline import Look

_SAMPLES = Path(__file__).resolve().parent.parent / "samples"
_PAINTED_ROUNDS, _PAINTED_FRAMES = 3, 120  # enough for a median


@dataclass(frozen=True, slots=True, kw_only=True)
class Extras:
    """What is measured besides the video itself.

    renderer: painting by itself, and the floor.  faces: the cost by number of faces.  threads:
    other numbers of threads.  minutes: length of a long video, 0 for none.  looks: how many looks
    of one video, 0 for none.  chromium: the page of a live run in Chromium.
    """

    renderer: bool = True
    faces: bool = False
    threads: bool = False
    minutes: float = 0.0
    looks: int = 0
    chromium: bool = False


def heights_of(sizes: str) -> list[int]:
    """Heights in pixels from "720p,1080p". Raises UsageError."""
    from makeup_video.pipeline.errors import UsageError, option

    parts = [part.removesuffix("p") for part in sizes.split(",")]
    heights = [int(part) for part in parts if part.isascii() and part.isdecimal() and len(part) < 5]
    if len(heights) != len(parts) or any(not 2 <= h <= 4320 or h % 2 for h in heights):
        raise UsageError(
            f"{option('sizes')} must be even heights such as 720p,1080p, got {sizes!r}"
        )
    return heights


def check_options(
    seconds: float,
    rounds: int,
    extras: Extras,
    *,
    live: bool,
    plot: str | None,
    against: str | None = None,
) -> None:
    """Check the options before anything is measured.

    Raises UsageError, OutputError, InstallError.
    """
    from makeup_video.pipeline.errors import UsageError, option

    if not (0.5 <= seconds <= 3600 and rounds >= 1):
        raise UsageError(
            f"{option('seconds')} must be 0.5 to 3600 and {option('rounds')} at least 1, got "
            f"{seconds:g} and {rounds}"
        )
    if not 0 <= extras.minutes <= 600:
        raise UsageError(f"{option('minutes')} must be 0 to 600 minutes, got {extras.minutes:g}")
    if extras.looks and not 2 <= extras.looks <= 100:
        raise UsageError(f"{option('looks')} must be 2 to 100, got {extras.looks}")
    others = extras.faces or extras.threads or extras.looks or plot is not None
    if live and others:
        raise UsageError(
            f"{option('live')} is measured alone: leave out {option('faces')}, "
            f"{option('threads')}, {option('looks')} and {option('plot')}"
        )
    if extras.chromium:
        if not live:
            raise UsageError(f"{option('chromium')} needs {option('live')}")
        from makeup_video.benchmark.live_browser import find_browser

        find_browser()
    if against is not None and (others or live or extras.minutes):
        raise UsageError(
            f"{option('against')} is measured alone: leave out {option('live')}, "
            f"{option('faces')}, {option('threads')}, {option('looks')}, {option('minutes')} and "
            f"{option('plot')}"
        )
    if plot is not None:
        from makeup_video.benchmark.plots import check_plot_path

        check_plot_path(plot)


def other_version(python: str) -> "Version":
    """The version of the product that another interpreter has. Raises UsageError."""
    from makeup_video.benchmark import against

    return against.other_version(python)


def sample_clip(clip: str | None) -> Path:
    """The clip to measure with, by default our sample.

    Raises InputError when the clip is missing or is a picture.
    """
    from makeup_video.pipeline import InputError
    from makeup_video.pipeline.files.local_file import local_file
    from makeup_video.pipeline.images.picture_file import is_picture

    source = Path(clip) if clip else _SAMPLES / "in.mp4"
    if clip is None and not source.exists():
        raise InputError(
            f"the sample {source} is not installed: give a CLIP to measure with, such as "
            "samples/in.mp4 in a clone"
        )
    source = local_file(source, "video")
    if is_picture(source):
        raise InputError(f"{source} is a picture, and a benchmark needs a video: give one")
    return source


def check_sources(look: str | None, ref: str | None) -> None:
    """Check the sources of the look. Raises UsageError when both a look and a photo are given, and
    InputError for a photo that does not exist."""
    from makeup_video.pipeline.errors import UsageError, option
    from makeup_video.pipeline.files.local_file import local_file

    if look is not None and ref is not None:
        raise UsageError(
            f"{option('look')} and {option('ref')} both give a look: leave one of them out"
        )
    if ref is not None:
        local_file(ref, "photo")


def sample_look(look: str | None, ref: str | None) -> "tuple[Look, Path | None]":
    """The look to paint, and the photo that it was read from, if any.

    By default this is the look of our sample photo. If that photo is missing, it is a look of lips
    and eyes with every effect. Raises LookError, InputError, PhotoError.
    """
    from makeup_video.pipeline.engine.machine import FIND_FACES, check_memory
    from makeup_video.pipeline.look.ready import load_look

    if look is not None:
        return load_look(look), None
    photo = Path(ref) if ref is not None else _SAMPLES / "look.jpg"
    if ref is None and not photo.exists():
        from makeup_video.benchmark.renderer import full_look

        return full_look(), None
    check_memory(FIND_FACES)  # with less memory, the libraries of the nets crash as they load
    from makeup_video.pipeline.reference.estimate import estimate_from

    return estimate_from(photo).look, photo


def run_suite(
    bench: "Bench",
    heights: list[int],
    extras: Extras,
    *,
    live: bool,
    against: "Version | None" = None,
) -> dict[str, Any]:
    """Measure, and return the results as the command prints them with --json."""
    if against is not None:
        from makeup_video.benchmark.against import compare_versions

        return {"against": compare_versions(bench, heights, against)}
    if live:
        from makeup_video.benchmark.live import measure_live

        return {"live": measure_live(bench, heights, extras.minutes, extras.chromium)}
    results = measure(bench, heights, renderer=extras.renderer)
    return results | measure_scaling(bench, heights[0], extras)


def measure(bench: "Bench", heights: list[int], *, renderer: bool) -> dict[str, Any]:
    """What every run of the command measures, by size."""
    from makeup_video.benchmark.video_costs import compare, own_process
    from makeup_video.benchmark.videos import CODEC, CRF, PRESET

    results: dict[str, Any] = {
        "clip": bench.source.name,
        "codec": f"{CODEC} {PRESET} crf {CRF}",
        "look": bench.look.to_dict(),
        "rounds": bench.rounds,
        "sizes": {},
    }
    for height in heights:
        name = f"{height}p"
        video = bench.video(height)
        row = compare(bench, video, name) | own_process(bench, video, name)
        if renderer:
            row |= _painting(bench, video.path, name, row["product"]["not_codec_cpu_ms"])
        results["sizes"][name] = row
    return results


def _painting(bench: "Bench", video: Path, name: str, measured_ms: float) -> dict[str, Any]:
    """The renderer by itself with a look of every effect, and the floor of the painted look."""
    from makeup_video.benchmark.floor import floor_of
    from makeup_video.benchmark.renderer import find_in, kernel_alone, paint_costs
    from makeup_video.benchmark.videos import first_frames

    bench.log(f"{name}: painting by itself")
    short = bench.folder / "painted.mkv"
    first_frames(video, short, _PAINTED_FRAMES)
    costs = paint_costs(short, min(bench.rounds, _PAINTED_ROUNDS))
    bench.log(f"{name}: the floor")
    kernel = kernel_alone(short, find_in(short), bench.look)
    floor = floor_of(short, bench.folder, round(kernel["painted_px"]))
    return {"renderer": costs, "floor": floor, "times_the_floor": measured_ms / floor["least_ms"]}


def measure_scaling(bench: "Bench", height_px: int, extras: Extras) -> dict[str, Any]:
    """The cost by faces, threads, looks and length at one size; only those that were asked for."""
    from makeup_video.benchmark.scaling import by_faces, by_threads, over_length

    results: dict[str, Any] = {}
    if extras.faces:
        results["faces"] = by_faces(bench, height_px)
    if extras.threads:
        video = bench.video(height_px)
        results["threads"] = {"size": f"{height_px}p", **by_threads(bench, video, "threads")}
    if extras.looks:
        from makeup_video.benchmark.many import by_looks

        video = bench.video(height_px)
        results["looks"] = {"size": f"{height_px}p", **by_looks(bench, video, extras.looks)}
    if extras.minutes:
        length = over_length(bench, height_px, extras.minutes)
        results["length"] = {"size": f"{height_px}p", **length}
    return results
