"""What all comparisons of `makeup-video bench` share: the input, the rounds, the medians."""

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from makeup_video.benchmark.runs import Run
from makeup_video.benchmark.videos import RATE, Video, make_video
from makeup_video.pipeline import Look, UsageError
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.media.codecs import PLAYS_EVERYWHERE
from makeup_video.pipeline.offline.encoding import decoder_threads, encoder_threads

# (decoder threads, encoder threads); 0: FFmpeg's own choice. The bare loop uses the best pair.
BARE_THREADS = ((0, 0), (1, 2), (2, 3), (2, 4))


@dataclass(slots=True)
class Bench:
    """The input and the settings of all measurements. Raises UsageError for a bare look.

    source: the clip that the videos are made from.  folder: for videos and outputs.
    look: what is painted.  photo: the photo that the look was read from, None for a look file; the
    command that is measured in its own process reads the photo, too.  seconds: length of a video.
    log: gets a line for each step.  child_stderr: a file descriptor for errors of child processes,
    None for ours.  look_file: the file that the look was read from, if any. The commands read this
    file, since an older version may not be able to read a file that this version writes.
    look_words: the options that give the command this look.
    """

    source: Path
    folder: Path
    look: Look
    _: KW_ONLY
    seconds: float
    rounds: int
    as_is: bool = False
    log: Callable[[str], None] = lambda text: None
    photo: Path | None = None
    child_stderr: int | None = None
    look_file: Path | None = None
    look_words: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        if self.look.is_bare:
            regions = " or ".join(PARTS)
            raise UsageError(f"the look paints nothing: give one with {regions} to measure with")
        if self.photo is not None:
            self.look_words = "--ref", str(self.photo)
            return
        if self.look_file is None:
            self.look_file = self.folder / "look.json"
            self.look.save(self.look_file)
        self.look_words = "--look", str(self.look_file)

    def video(self, height_px: int, seconds: float | None = None, **options: Any) -> Video:
        """Make the video to measure with, at a height; options: as for make_video."""
        self.log(f"{height_px}p: making the video")
        frames = round((seconds or self.seconds) * RATE)
        target = self.folder / f"video{height_px}.mp4"
        return make_video(self.source, target, height_px, frames, as_is=self.as_is, **options)


def in_turn(
    bench: Bench, title: str, work: Mapping[str, Callable[[], Run]], rounds: int
) -> dict[str, list[Run]]:
    """Run each piece of work once a round; every round begins with another piece."""
    runs: dict[str, list[Run]] = {name: [] for name in work}
    order = list(work)
    for number in range(rounds):
        first = number % len(order)
        for name in order[first:] + order[:first]:
            bench.log(f"{title}: round {number + 1} of {rounds}, {name}")
            runs[name].append(work[name]())
    return runs


def middle(runs: list[Run]) -> dict[str, Any]:
    """The medians of the runs, and the frames/s of the slowest and the quickest run."""
    fps = [run.fps for run in runs]
    return {
        "fps": median(fps),
        "fps_spread": [min(fps), max(fps)],
        "cpu_ms_per_frame": median(run.cpu_ms_per_frame for run in runs),
    }


def beside(runs: list[Run], bare: list[Run], codec: list[Run] | None = None) -> dict[str, Any]:
    """Compare runs with the runs of the bare loop in the same rounds.

    codec: runs of the codec alone; None: the bare loop stands for them, too.
    ratio: frames/s divided by the frames/s of the bare loop.  not_codec_cpu_ms: CPU time per frame
    beyond the codec's.
    """
    ratios = [ours.fps / limit.fps for ours, limit in zip(runs, bare, strict=True)]
    return {
        "ratio": median(run.fps for run in runs) / median(run.fps for run in bare),
        "ratio_spread": [min(ratios), max(ratios)],
        "not_codec_cpu_ms": median(
            ours.cpu_ms_per_frame - codec_alone.cpu_ms_per_frame
            for ours, codec_alone in zip(runs, codec or bare, strict=True)
        ),
    }


def own_threads(video: Video | None = None) -> tuple[int, int]:
    """Threads of decoder and encoder as the product chooses them for a video; 0: FFmpeg chooses.

    video: None stands for any video of at most 1440p.
    """
    frame_px = video.size_wh[0] * video.size_wh[1] if video else 0
    return decoder_threads(), encoder_threads(PLAYS_EVERYWHERE, frame_px)
