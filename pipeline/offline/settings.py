"""The settings of an offline run: what to keep, how to write it, and who is painted."""

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from numbers import Integral
from typing import Self

from makeup_video.pipeline.engine.runner import Observe
from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.look.params import shown
from makeup_video.pipeline.look.unchangeable import unchangeable
from makeup_video.pipeline.media.hardware import NONE, check_hardware

BIT_DEPTHS = (8, 10, 12)
_FLAGS = ("overwrite", "strict", "sdr", "compare")
_TEXTS = ("codec", "preset")
_FUNCTIONS = ("observe", "on_whole")
# The lowest and highest value of each whole number. The codec knows the range of crf. There may be
# any number of processes, but not of threads, since each thread of a decoder takes some MB.
_RANGES = {
    "crf": (-math.inf, math.inf),
    "jobs": (1, math.inf),
    "decoder_threads": (0, 128),
    "encoder_threads": (0, 128),
    "stage_threads": (1, 128),
}
# settings that a picture does not have
_OF_VIDEOS = (
    "codec",
    "crf",
    "preset",
    "hardware",
    "start_seconds",
    "end_seconds",
    "bit_depth",
    "sdr",
    "decoder_threads",
    "encoder_threads",
    "stage_threads",
    "split_minutes",
    "jobs",
)


_CHOICES = {"faces": "all", "device": "", "hardware": NONE}  # what None stands for


def choice(name: str, value: object) -> str:
    """The text of one of _CHOICES, whose value may also be a number or None."""
    return _CHOICES[name] if value is None else str(value)


@unchangeable("dataclasses.replace makes another")
@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How to write the output. None stands for the default that suits source and container.

    codec, crf, preset: of the video encoder.
    hardware: a hardware encoder, see `media/hardware.py`. "auto" takes the first one that works,
    or else the codec's own encoder; "none" never takes a hardware encoder.
    start_seconds, end_seconds: the excerpt to keep, counted from where the file begins.
    overwrite: replace an output that exists.
    strict: raise rather than drop or convert a stream.
    bit_depth: 8, 10 or 12 bits per sample; None: as in the source, but 8 in H.264.
    sdr: turn HDR into SDR.
    faces: whom to paint: "all", "largest", or the number of a face, as inspect_video draws it.
    compare: show before and after side by side.
    split_minutes: paint the video in segments of about this many minutes, each in its own process,
    and join them; None: paint it in one run.
    jobs: how many segments are painted at once; None: half as many as there are cores.
    device: the OpenCL device that paints, by its number or a part of its name; "": the processor.
    decoder_threads, encoder_threads: 0: FFmpeg chooses. None: for the decoder half as many as there
    are cores; for the encoder FFmpeg's choice, but one per core for H.264 of 6 million px and more.
    stage_threads: threads that share the stages between decoder and encoder; None: as in Runner.
    observe: called with the time that each stage took for each item, by the threads of the stages.
    on_whole: called, by any thread, when the output is whole and about to get its name.

    faces and device may be ints. A float or Decimal in place of a Fraction counts as exactly the
    decimals that it is shown with. Raises UsageError.
    """

    codec: str | None = None
    crf: int | None = None
    preset: str | None = None
    hardware: str = NONE
    start_seconds: Fraction | None = None
    end_seconds: Fraction | None = None
    overwrite: bool = False
    strict: bool = False
    bit_depth: int | None = None
    sdr: bool = False
    faces: str = "all"
    compare: bool = False
    split_minutes: Fraction | None = None
    jobs: int | None = None
    device: str = ""
    decoder_threads: int | None = None
    encoder_threads: int | None = None
    stage_threads: int | None = None
    observe: Observe | None = None
    on_whole: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        for name in _CHOICES:
            object.__setattr__(self, name, choice(name, getattr(self, name)))
        for name in ("start_seconds", "end_seconds", "split_minutes"):
            object.__setattr__(self, name, _exact(getattr(self, name), name))
        self._check_types()
        check_whom(self.faces)
        check_hardware(self.hardware)
        if not (self.bit_depth is None or self._has_known_depth()):
            raise UsageError(
                f"{option('bit_depth')} must be one of {', '.join(map(str, BIT_DEPTHS))}, got "
                f"{self.bit_depth!r}"
            )
        start, end = self.start_seconds or Fraction(0), self.end_seconds
        if start < 0 or (end is not None and end <= start):
            raise UsageError(
                f"{option('start_seconds')} must be at least 0 and {option('end_seconds')} later "
                f"than it, got {float(start):g} s to "
                f"{'the end' if end is None else f'{float(end):g} s'}"
            )
        self._check_split()

    def _has_known_depth(self) -> bool:
        return isinstance(self.bit_depth, Integral) and self.bit_depth in BIT_DEPTHS

    def _check_types(self) -> None:
        for name in _FLAGS:
            value = getattr(self, name)
            if not isinstance(value, bool):
                raise UsageError(f"{option(name)} must be True or False, got {value!r}")
        for name in _TEXTS:
            value = getattr(self, name)
            if not isinstance(value, str | None):
                raise UsageError(f"{option(name)} must be text or None, got {value!r}")
        for name in _FUNCTIONS:
            value = getattr(self, name)
            if not (value is None or callable(value)):
                raise UsageError(f"{option(name)} must be a function or None, got {value!r}")
        for name, (least, most) in _RANGES.items():
            value = getattr(self, name)
            whole = isinstance(value, Integral) and not isinstance(value, bool)
            if value is None or (whole and least <= value <= most):
                continue
            of = f" in {least}..{most}" if most < math.inf else ""
            of = of or (f" of at least {least}" if least > -math.inf else "")
            raise UsageError(f"{option(name)} must be a whole number{of}, got {value!r}")

    def _check_split(self) -> None:
        minutes, jobs = self.split_minutes, self.jobs
        if minutes is None:
            if jobs is not None:
                raise UsageError(f"{option('jobs')} needs {option('split_minutes')}")
            return
        if minutes <= 0:
            raise UsageError(
                f"{option('split_minutes')} must be more than 0, got {float(minutes):g}"
            )
        if self.hardware != NONE:
            # other machines and later attempts must write the same headers
            raise UsageError(
                f"{option('hardware')} cannot be combined with {option('split_minutes')}: leave "
                "one of them out"
            )

    @classmethod
    def checked(cls, settings: object) -> Self:
        """The settings, or the defaults for None. Raises TypeError for another type."""
        if settings is None:
            return cls()
        if not isinstance(settings, cls):
            raise TypeError(
                f"settings must be Settings, got {type(settings).__name__}: Settings(crf=24) makes "
                "them"
            )
        return settings

    def of_videos(self) -> list[str]:
        """Names of the settings that are given and apply to videos only."""
        return self.given(_OF_VIDEOS)

    def for_pictures(self) -> Self:
        """The same settings without those that apply to videos only."""
        default = Settings()
        return replace(self, **{name: getattr(default, name) for name in _OF_VIDEOS})

    def given(self, names: Iterable[str]) -> list[str]:
        """Those of the names whose settings are not the defaults."""
        default = Settings()
        return [name for name in names if getattr(self, name) != getattr(default, name)]


def _exact(value: object, name: str) -> Fraction | None:
    """The exact value of the decimals that a number is shown with, whatever its type.

    The float 0.1 is a little more than 1/10, so a frame at 1/10 s would be left out.
    Raises UsageError.
    """
    if value is None:
        return None
    try:
        exact = value if isinstance(value, Fraction) else Fraction(str(value))
        float(exact)  # as messages show it
    except (ValueError, ZeroDivisionError, OverflowError) as error:
        unit = name.rpartition("_")[2]
        raise UsageError(
            f"{option(name)} must be a number of {unit}, got {shown(value, repr)}"
        ) from error
    return exact


def is_number(value: object) -> bool:
    """True for any type of number, of numpy too, but not for text."""
    return hasattr(value, "__float__") and not isinstance(value, str)


def check_progress(on_progress: object) -> None:
    """Raises TypeError unless on_progress is a function or None."""
    if not (on_progress is None or callable(on_progress)):
        raise TypeError(f"on_progress must be a function or None, got {type(on_progress).__name__}")


def check_workers(workers: object) -> None:
    """Raises TypeError unless `workers` is None or a sequence of workers."""
    if workers is None:
        return
    are_workers = isinstance(workers, Sequence) and all(
        hasattr(one, "run") and hasattr(one, "stop") for one in workers
    )
    if not are_workers:
        raise TypeError(
            f"workers must be a list of workers, got {workers!r}: on_ray.ray_workers() makes them; "
            "Settings(jobs=...) says how many processes of this machine paint"
        )


def check_whom(faces: str) -> None:
    """Raises UsageError unless `faces` says whom to paint."""
    if not re.fullmatch(r"all|largest|0|[1-9][0-9]{0,8}", faces):
        raise UsageError(
            f"{option('faces')} must be all, largest, or the number of a face, got {faces!r}"
        )
