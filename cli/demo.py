"""`makeup-video demo`: the page to play with, without a camera."""

import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import say
from makeup_video.cli.outcome import told_in_one_line
from makeup_video.cli.serve_page import PORT, page

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.web.portrait import Portrait

_COLOUR = 180, 0, 46  # the README's red


def demo(
    portrait: Annotated[
        str | None,
        typer.Argument(metavar="[PORTRAIT]", help="Whom to paint; left out: our own portrait."),
    ] = None,
    ref: Annotated[
        str | None, typer.Option(metavar="PHOTO", help="Begin with the makeup of a photo.")
    ] = None,
    look: Annotated[
        str | None, typer.Option(metavar="FILE", help="Begin with a look file.")
    ] = None,
    host: Annotated[
        str, typer.Option(help="Where the page listens; 0.0.0.0 for other machines too.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Of the page; 0 for any free one.")] = PORT,
    browser: Annotated[bool, typer.Option(help="Open the page when it is there.")] = True,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Open a page: drop a photo, see its makeup as numbers and on a portrait, change it."""
    from makeup_video.web.demo_session import DemoShow
    from makeup_video.web.session import PhotoLook
    from makeup_video.web.worker import Worker

    with told_in_one_line(debug=debug):
        worker = Worker()
        worn = _look(ref, look)
        show = DemoShow(
            _portrait(portrait),
            worn,
            worker,
            say,
            photo=PhotoLook(Path(ref).name, worn) if ref else None,
        )
        with page(show, worker, host, port, browser=browser, told=say):
            try:
                threading.Event().wait()
            except KeyboardInterrupt:
                say("stopped")  # as it was meant to end: exit code 0


def _portrait(path: str | None) -> "Portrait":
    from makeup_video.web.app import PAGE
    from makeup_video.web.portrait import Portrait

    file = str(PAGE / "portrait.jpg") if path is None else path
    return Portrait(_bytes(file), file)


def _look(ref: str | None, look: str | None) -> "Look":
    from makeup_video.pipeline import Look, UsageError, product
    from makeup_video.web.read_look import read_look

    if ref is not None and look is not None:
        raise UsageError("--ref and --look both say what to begin with: give one of them")
    if ref is not None:
        return read_look(_bytes(ref), ref)
    if look is not None:
        return Look.load(look)
    return Look(lips=product(_COLOUR, "satin"))


def _bytes(path: str) -> bytes:
    from makeup_video.pipeline.media.input_file import local_file

    return local_file(path, "photo").read_bytes()
