"""Options that several commands share, each defined once, and the groups of the help."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from fractions import Fraction

    from makeup_video.pipeline.engine.jobs import Worker

PROGRAM, DEFAULT = "makeup-video", "apply"  # the default command needs no name

# Groups of options in the help, in the order in which a page lists them.
LOOK, FACES, CAMERA, VIDEO, MEASUREMENTS = "Look", "Faces", "Camera", "Video", "Measurements"
OUTPUT, PAGE, RUN = "Output", "Page", "Run"
GROUPS = (LOOK, FACES, CAMERA, VIDEO, MEASUREMENTS, OUTPUT, PAGE, RUN)

PORT = 8760
COLOUR = "COLOUR"  # begins the metavar of every option that takes a colour

Source = Annotated[str, typer.Argument(metavar="IN", help="A video or a picture.")]
RefPhoto = Annotated[
    str | None,
    typer.Option(metavar="PHOTO", help="A photo of the makeup to paint.", rich_help_panel=LOOK),
]
SavedLook = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="A ready look, or a look file (JSON).", rich_help_panel=LOOK),
]
Start = Annotated[
    str | None,
    typer.Option(
        metavar="TIME",
        help="Begin here: seconds, or [hh:]mm:ss[.fraction].",
        rich_help_panel=OUTPUT,
    ),
]
End = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="End here, on the same clock.", rich_help_panel=OUTPUT),
]
Overwrite = Annotated[
    bool, typer.Option("-y", "--yes", help="Overwrite files that exist.", rich_help_panel=OUTPUT)
]
PrintJson = Annotated[bool, typer.Option("--json", help="Print JSON.", rich_help_panel=OUTPUT)]
Quiet = Annotated[
    bool, typer.Option("-q", "--quiet", help="Print errors only.", rich_help_panel=RUN)
]
Debug = Annotated[bool, typer.Option("--debug", help="Show tracebacks.", rich_help_panel=RUN)]

# "1h 2m 3.5s", "90s", "2 min": at least one unit
_SPOKEN_TIME = re.compile(
    r"(?=.*[a-z])(?:(\d{1,9})\s*h(?:ours?|rs?)?)?\s*(?:(\d{1,9})\s*m(?:in(?:ute)?s?)?)?\s*"
    r"(?:(\d{1,9}(?:\.\d{1,9})?)\s*s(?:ec(?:ond)?s?)?)?",
    re.ASCII,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PageOptions:
    """Where the page in the browser is served."""

    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS",
            help="Address of the page; 0.0.0.0 lets other machines see it.",
            rich_help_panel=PAGE,
        ),
    ] = "127.0.0.1"
    port: Annotated[
        int,
        typer.Option(
            metavar="PORT", help="Port of the page; 0 for any free one.", rich_help_panel=PAGE
        ),
    ] = PORT
    https: Annotated[
        bool,
        typer.Option(
            "--https",
            help="Serve the page over HTTPS, with a certificate that is made once. "
            "Needs makeup-video[https].",
            rich_help_panel=PAGE,
        ),
    ] = False
    certificate: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Your own certificate for HTTPS, with its chain (PEM).",
            rich_help_panel=PAGE,
        ),
    ] = None
    key: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="The key of --certificate (PEM), unless that file holds it.",
            rich_help_panel=PAGE,
        ),
    ] = None
    browser: Annotated[
        bool, typer.Option(help="Open the page in a browser.", rich_help_panel=PAGE)
    ] = True


@dataclass(frozen=True, slots=True, kw_only=True)
class ClusterOptions:
    """Which machines do the work."""

    ray: Annotated[
        str | None,
        typer.Option(
            "--ray",
            metavar="ADDRESS",
            help="Work on a Ray cluster: HOST:PORT of its head, or auto for the one that this "
            "machine belongs to. Needs makeup-video[ray].",
            rich_help_panel=RUN,
        ),
    ] = None
    ship: Annotated[
        bool,
        typer.Option(
            "--ship",
            help="Send inputs and outputs through the cluster, for machines that share no folder.",
            rich_help_panel=RUN,
        ),
    ] = False

    def check(self) -> None:
        """Raises UsageError when an option needs a cluster but --ray is missing."""
        from makeup_video.pipeline import UsageError

        if self.ship and self.ray is None:
            raise UsageError("--ship is for a cluster: add --ray ADDRESS, or leave it out")

    @contextmanager
    def workers(self, count: int | None) -> "Iterator[Sequence[Worker] | None]":
        """Yield `count` workers of the cluster within the block; None without --ray.

        Raises InstallError without Ray, WorkerError without a cluster.
        """
        from makeup_video.pipeline import InstallError

        if self.ray is None:
            yield None
            return
        try:
            from makeup_video.pipeline.batch import on_ray
        except ImportError as error:
            raise InstallError("--ray needs Ray: pip install 'makeup-video[ray]'") from error
        with on_ray.cluster(self.ray):
            yield on_ray.ray_workers(count, ship=self.ship)


def with_options(command: Callable[..., None]) -> Callable[..., None]:
    """Replace each parameter that is a dataclass of options by the fields of the dataclass.

    Typer then sees one option per field; the command receives the dataclass.
    """
    bundles: dict[str, Any] = {}
    flat: list[Parameter] = []
    for name, parameter in signature(command).parameters.items():
        if is_dataclass(parameter.annotation):
            bundles[name] = parameter.annotation
            flat += [_parameter(f.name, f.type, f.default) for f in fields(parameter.annotation)]
        else:
            flat.append(_parameter(name, parameter.annotation, parameter.default))

    @wraps(command)
    def run(**values: Any) -> None:
        for name, kind in bundles.items():
            values[name] = kind(**{field.name: values.pop(field.name) for field in fields(kind)})
        command(**values)

    run.__signature__ = Signature(flat)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in flat}
    return run


def _parameter(name: str, annotation: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=default)


def parse_time(text: str | None, option: str) -> "Fraction | None":
    """Exact seconds from "12.5", "12.5s", "1m 2.5s", "1:02.5" or "0:01:02.5"; None stays None.

    Raises UsageError.
    """
    if text is None:
        return None
    from fractions import Fraction

    from makeup_video.pipeline import UsageError

    time = text.strip().lower()
    if spoken := _SPOKEN_TIME.fullmatch(time):
        hours, minutes, seconds = (Fraction(part or 0) for part in spoken.groups())
        return 3600 * hours + 60 * minutes + seconds
    if not re.fullmatch(r"(\d{1,9}:){0,2}(\d{1,9}(\.\d{1,9})?|\.\d{1,9})", time, re.ASCII):
        raise UsageError(f"{option} must be seconds or [hh:]mm:ss[.fraction], got {text!r}")
    values = [Fraction(part) for part in time.split(":")]
    if any(value >= 60 for value in values[1:]):
        raise UsageError(
            f"{option}: what follows a colon must be below 60, as in 1:30, got {text!r}"
        )
    return sum((v * 60**i for i, v in enumerate(reversed(values))), Fraction(0))
