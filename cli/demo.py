"""`makeup-video demo`: the page to play with, without a camera."""

import time
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import log
from makeup_video.cli.options import Debug, PageOptions, RefPhoto, SavedLook, with_options
from makeup_video.cli.outcome import report_errors

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.web.portrait import Portrait

EXAMPLES = (
    "makeup-video demo",
    "makeup-video demo --ref look.jpg",
    "makeup-video demo me.jpg --look glam",
)
_WAKE_SECONDS = 0.5  # a Ctrl-C is noticed within this time


@with_options
def demo(
    page: PageOptions,
    portrait: Annotated[
        str | None,
        typer.Argument(
            metavar="[PORTRAIT]", help="The portrait to paint; default: one that is included."
        ),
    ] = None,
    ref: RefPhoto = None,
    look: SavedLook = None,
    debug: Debug = False,
) -> None:
    """Open a page without a camera: read a photo's makeup, see it on a portrait, change it."""
    from makeup_video.cli.serve_page import serve_page
    from makeup_video.web.demo_session import DemoShow
    from makeup_video.web.read_look import look_of_file
    from makeup_video.web.slow_jobs import SlowJobs

    with report_errors("demo", debug=debug):
        slow_jobs = SlowJobs()
        first = _first_look(ref, look)
        photo = look_of_file(ref, first) if ref else None
        show = DemoShow(_portrait(portrait), first, slow_jobs, log, photo=photo)
        with serve_page(show, slow_jobs, page, log):
            try:
                # The system may deliver a signal to another thread, which does not wake this one.
                while True:
                    time.sleep(_WAKE_SECONDS)
            except KeyboardInterrupt:
                log("stopped")  # the usual end: exit code 0


def _portrait(path: str | None) -> "Portrait":
    from makeup_video.pipeline.images.photo_file import read_photo
    from makeup_video.web.portrait import Portrait, own_portrait

    return own_portrait() if path is None else Portrait(read_photo(path), path)


def _first_look(ref: str | None, look: str | None) -> "Look":
    from makeup_video.cli.look_options import check_sources
    from makeup_video.pipeline import KINDS, Look, product
    from makeup_video.pipeline.engine.machine import FIND_FACES, check_memory
    from makeup_video.pipeline.look.ready import load_look
    from makeup_video.web.read_look import check_worn

    check_sources(look, ref)
    if ref is not None:
        check_memory(FIND_FACES)  # with less memory, the libraries of the nets crash as they load
        from makeup_video.pipeline.reference.estimate import estimate_from

        return check_worn(estimate_from(ref).look, ref)
    if look is not None:
        return load_look(look)
    return Look(lips=product(KINDS["lipstick"].first_rgb, "satin"))
