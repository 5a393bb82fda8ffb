"""One case: a damaged file and what is run on it, all derived from kind, seed and number."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from random import Random

from fuzz.mutate import mutate
from fuzz.mutate_photos import OWN as OWN_PHOTOS
from fuzz.mutate_texts import mutate_catalogue, mutate_look
from fuzz.mutate_videos import OWN as OWN_VIDEOS
from fuzz.seeds import Seeds

_SAMPLES = Path(__file__).parents[2] / "samples"
_OWN = {**OWN_VIDEOS, **OWN_PHOTOS}
_VIDEO_ENDS = (".mp4",) * 6 + (".mkv",) * 5 + (".mov",) * 3 + (".webm",)
_PICTURE_ENDS = (".jpg", ".png", ".webp")
_CODECS = {
    ".mp4": ("hevc", "h264"), ".mkv": ("ffv1", "hevc", "h264", "vp9"), ".mov": ("prores", "h264"),
    ".webm": ("vp9",),
}  # fmt: skip
_FASTEST = {"h264": "ultrafast", "hevc": "ultrafast", "vp9": "8"}
_COMMAND_SHARE = 0.1
_PAINT_SHARE = 0.25
_OLD_SHARE = 0.1


@dataclass(frozen=True, kw_only=True)
class Case:
    """A damaged file, and how the product is run on it.

    damage: the mutations that were applied, as text.  action: "video" and "picture" call
    process_video, "photo" and "bytes" look_from_photo, "look" and "catalogue" read a text file.
    by_command: run `makeup-video` itself, to check its exit code and its messages.
    has_old: an older output file exists, and -y is given.
    options: options of the command, without dashes; the value is None for a flag.
    """

    kind: str
    seed: str
    number: int
    name: str
    data: bytes
    damage: str
    action: str
    output: str | None = None
    paints: bool = False
    by_command: bool = False
    has_old: bool = False
    options: tuple[tuple[str, str | None], ...] = ()

    @property
    def input(self) -> str:
        return f"in{PurePath(self.name).suffix}"

    @property
    def is_trimmed(self) -> bool:
        return any(name in ("start", "end") for name, _ in self.options)

    @property
    def words(self) -> list[str]:
        """The command's arguments, for a run in the folder of the input."""
        if self.action in ("photo", "bytes"):
            return ["estimate", self.input]
        if self.action == "look":
            portrait = str(_SAMPLES / "portrait.jpg")
            return [portrait, "--look", self.input, "-o", "out.png", "-q", "-y"]
        if self.action == "catalogue":
            return ["estimate", str(_SAMPLES / "look.jpg"), "--catalogue", self.input]
        look = ["--color", "B4002E", "--parts", "lips,eyes"] if self.paints else ["--look", "none"]
        given: list[str] = []
        for name, value in self.options:
            given += [f"--{name}"] if value is None else [f"--{name}", value]
        ends = ["-o", str(self.output), "--report", "report.json", "-q", "-y"]
        return [self.input, *look, *given, *ends]

    @property
    def command(self) -> str:
        return shlex.join(["makeup-video", *self.words])


def make_case(kind: str, seed: str, number: int, seeds: Seeds, as_is: bool = False) -> Case:
    """Case `number`. as_is: take the undamaged files in turn, without unusual options."""
    r = Random(f"{seed}/{number}")
    names = tuple(seeds.files)
    name = names[number % len(names)] if as_is else r.choice(names)
    data, damage = seeds.files[name], "as it is"
    if not as_is:
        data, damage = _damaged(r, name, data, tuple(seeds.files.values()))
    action = _action(r, kind, name)
    case = Case(
        kind=kind, seed=seed, number=number, name=name, data=data, damage=damage, action=action
    )
    if action in ("video", "picture"):
        case = _with_output(r, case, as_is)
    by_command = r.random() < _COMMAND_SHARE * (0.5 if kind == "text" else 1)
    return replace(case, by_command=by_command)


def _damaged(r: Random, name: str, data: bytes, others: Sequence[bytes]) -> tuple[bytes, str]:
    suffix = PurePath(name).suffix
    if suffix == ".json":
        return mutate_look(r, data)
    if suffix == ".csv":
        return mutate_catalogue(r, data)
    return mutate(r, name, data, others, _OWN.get(suffix, ()))


def _action(r: Random, kind: str, name: str) -> str:
    if kind == "video":
        return "video"
    if kind == "text":
        return "look" if name.endswith(".json") else "catalogue"
    return r.choice(("photo", "photo", "bytes", "picture"))


def _with_output(r: Random, case: Case, as_is: bool) -> Case:
    end = r.choice(_VIDEO_ENDS if case.action == "video" else _PICTURE_ENDS)
    if as_is and end == ".webm":
        end = ".mkv"  # our VP9 output rightly refuses interlaced video
    options = [] if as_is else _options(r, case.action, end)
    return replace(
        case,
        output=f"out{end}",
        paints=r.random() < _PAINT_SHARE,
        has_old=r.random() < _OLD_SHARE,
        options=tuple(options),
    )


def _options(r: Random, action: str, end: str) -> list[tuple[str, str | None]]:
    options: list[tuple[str, str | None]] = []
    if r.random() < 0.1:
        options.append(("compare", None))
    if r.random() < 0.07:
        options.append(("strict", None))
    if action == "picture":
        return options
    if end == ".webm" or r.random() < 0.3:
        codec = r.choice(_CODECS[end])
        options.append(("codec", codec))
        if codec in _FASTEST:
            options.append(("preset", _FASTEST[codec]))
    if r.random() < 0.15:
        options.append(("start", r.choice(("0.1", "0.35", "5"))))
    if r.random() < 0.1:
        options.append(("end", r.choice(("5.2", "0.4", "100"))))
    return options
