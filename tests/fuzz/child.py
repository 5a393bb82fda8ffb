"""The process of one case: runs the product once and returns the outcome."""

import gc
import json
import sys
import traceback
from collections.abc import Mapping
from contextlib import chdir
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fuzz.case import Case
from fuzz.videos import VIDEOS

REPORT = "report.json"
FAULT = "fault"  # the outcome that is always wrong
_RGB = 180, 0, 46


@dataclass(frozen=True)
class Answer:
    """The outcome of one run.

    outcome: "done", "damaged" (done with the decodable part), "refused CLASS" or FAULT.
    detail: the message or the traceback.  report: `Report.to_dict()`, or None.
    """

    outcome: str
    detail: str = ""
    report: dict[str, Any] | None = None


def warm_up() -> None:
    """Import what cases need before the first fork, without starting a thread, a net or OpenCL."""
    import cv2
    import makeup_video.cli.app
    import makeup_video.cli.progress
    import makeup_video.pipeline.look.catalogue
    import makeup_video.pipeline.offline.stages
    import makeup_video.pipeline.reference.estimate  # noqa: F401
    from PIL import Image

    Image.init()
    cv2.setNumThreads(1)
    gc.collect()
    gc.freeze()  # otherwise children would copy the memory of every object the collector visits


def compile_kernels(kind: str, files: Mapping[str, bytes]) -> None:
    """Paint every seed with a face once: OpenCL caches its kernels on disk, so no case waits."""
    faces = [name for name, video in VIDEOS.items() if video.has_face] if kind == "video" else []
    faces += ["plain.png"] if kind == "photo" else []
    for name in faces:
        action, end = ("video", ".mkv") if kind == "video" else ("picture", ".png")
        with TemporaryDirectory() as folder, chdir(folder):
            case = Case(
                kind=kind, seed="", number=0, name=name, data=files[name], damage="", action=action,
                output=f"out{end}", paints=True,
            )  # fmt: skip
            Path(case.input).write_bytes(case.data)
            run(case)  # the cases report any fault


def run(case: Case) -> Answer:
    """Run the case through the public API, in the current folder. Any exception is an answer."""
    from makeup_video.pipeline.errors import InstallError, MakeupVideoError

    try:
        return _ACTIONS[case.action](case)
    except InstallError as error:
        return Answer(FAULT, f"InstallError: {error}")
    except MakeupVideoError as error:
        if len(str(error).splitlines()) != 1:
            return Answer(FAULT, f"not one line: {type(error).__name__}: {str(error)!r}")
        return Answer(f"refused {type(error).__name__}", str(error))
    except BaseException:  # noqa: BLE001  # MemoryError and SystemExit are faults, too
        return Answer(FAULT, traceback.format_exc())


def run_command(case: Case) -> None:
    """Run `makeup-video` as users do; this ends the process."""
    from makeup_video.cli.main import main

    sys.argv = ["makeup-video", *case.words]
    main()


def answer_of_command(code: int, stderr: str, place: Path) -> Answer:
    """The answer of a command, from its exit code, its stderr and its report in `place`."""
    from makeup_video.pipeline import errors

    lines, file = stderr.splitlines(), place / REPORT
    if code in (0, 5):
        report = json.loads(file.read_text()) if file.exists() else None
        return Answer("done" if code == 0 else "damaged", stderr, report)
    if code not in (2, 3, 4, 6):
        return Answer(FAULT, f"exit code {code}: {stderr}")
    names = [line.partition(":")[0] for line in lines]
    ours = [name for name in names if hasattr(errors, name)]
    if len(ours) != 1:
        return Answer(FAULT, f"exit code {code} with {len(ours)} lines of ours: {stderr}")
    return Answer(f"refused {ours[0]}", stderr)


def _video(case: Case) -> Answer:
    from makeup_video.pipeline import KINDS, Layer, Look, process_video, product

    look = Look()
    if case.paints:
        look = Look(Layer(k.name, product(_RGB, "shimmer", k.part)) for k in KINDS.values())
    report = process_video(case.input, str(case.output), look, _settings(case))
    report.summary(), report.warnings()
    values = json.loads(json.dumps(report.to_dict(), allow_nan=False))
    return Answer("damaged" if report.damaged else "done", report=values)


def _settings(case: Case) -> Any:
    from makeup_video.pipeline import Settings

    given = dict(case.options)
    start, end = given.get("start"), given.get("end")
    return Settings(
        overwrite=True,
        compare="compare" in given,
        strict="strict" in given,
        codec=given.get("codec"),
        preset=given.get("preset"),
        start_seconds=None if start is None else Fraction(start),
        end_seconds=None if end is None else Fraction(end),
    )


def _photo(case: Case) -> Answer:
    from makeup_video.pipeline import look_from_photo

    photo = case.data if case.action == "bytes" else case.input
    json.dumps(look_from_photo(photo).to_dict(), allow_nan=False)
    return Answer("done")


def _look(case: Case) -> Answer:
    from makeup_video.pipeline import Look

    look = Look.load(case.input)
    if Look.from_dict(json.loads(json.dumps(look.to_dict(), allow_nan=False))) != look:
        return Answer(FAULT, "the look is another one after it was written and read")
    return Answer("done")


def _catalogue(case: Case) -> Answer:
    from makeup_video.pipeline.look.catalogue import read_catalogue

    if not read_catalogue(case.input).nearest(_RGB):
        return Answer(FAULT, "a catalogue was read, and nothing in it is nearest")
    return Answer("done")


_ACTIONS = {
    "video": _video, "picture": _video, "photo": _photo, "bytes": _photo, "look": _look,
    "catalogue": _catalogue,
}  # fmt: skip
