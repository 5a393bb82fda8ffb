"""`makeup-video live --ref look.jpg`: a camera in, a made-up picture out, now."""

import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import say
from makeup_video.cli.look_options import (
    Color,
    Faces,
    Finish,
    Intensity,
    LookFile,
    OpenclDevice,
    Parts,
    RefFace,
    RefPhoto,
    Strength,
    Zone,
    base_look,
)
from makeup_video.cli.outcome import option_of_command, told_in_one_line
from makeup_video.cli.progress import live_summary, show_live
from makeup_video.cli.serve_page import PORT, page

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.live.interfaces import LiveSink
    from makeup_video.pipeline.live.run import LiveRun
    from makeup_video.pipeline.live.sources.camera import Camera
    from makeup_video.pipeline.look.options import Choice

_NOBODY = "--no-preview leaves nobody to see it: add -o OUT, --stream URL or --virtual-camera"


def live(
    camera: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A camera, or a video that plays; default: the first."),
    ] = None,
    ref: RefPhoto = None,
    ref_face: RefFace = None,
    look: LookFile = None,
    color: Color = None,
    finish: Finish = None,
    parts: Parts = None,
    zone: Zone = None,
    intensity: Intensity = None,
    strength: Strength = None,
    faces: Faces = "all",
    device: OpenclDevice = "",
    size: Annotated[str, typer.Option(metavar="WxH", help="Asked of the camera.")] = "1280x720",
    fps: Annotated[int, typer.Option(help="Frames a second, asked of the camera.")] = 30,
    pixels: Annotated[
        str | None, typer.Option(help="mjpeg or yuyv422, asked of the camera; default: the faster.")
    ] = None,
    loop: Annotated[
        bool, typer.Option("--loop", help="A video as camera begins anew at its end.")
    ] = False,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="OUT", help="Record into this file.")
    ] = None,
    stream: Annotated[
        list[str] | None,
        typer.Option(metavar="URL", help="Send to rtmp://, srt:// or udp://; may be repeated."),
    ] = None,
    virtual_camera: Annotated[
        bool,
        typer.Option("--virtual-camera", help="Be a camera to other programs (extra virtualcam)."),
    ] = False,
    preview: Annotated[bool, typer.Option(help="Show it in the browser.")] = True,
    host: Annotated[
        str, typer.Option(help="Where the page listens; 0.0.0.0 for other machines too.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Of the page; 0 for any free one.")] = PORT,
    browser: Annotated[bool, typer.Option(help="Open the page when it is there.")] = True,
    overwrite: Annotated[bool, typer.Option("-y", "--yes", help="Overwrite OUT.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Paint a look on what a camera sees: in the browser, a recording, a stream, a virtual camera."""
    from makeup_video.pipeline import UsageError
    from makeup_video.pipeline.images.jpeg import PreviewJpeg
    from makeup_video.pipeline.live.run import LiveRun
    from makeup_video.pipeline.live.sources.camera import Camera, CameraSettings
    from makeup_video.pipeline.look.options import Choice
    from makeup_video.web.live_session import LiveShow
    from makeup_video.web.preview_sink import PreviewSink
    from makeup_video.web.session import PhotoLook
    from makeup_video.web.worker import Worker

    with told_in_one_line(None, debug), ExitStack() as stack:
        told = _silent if quiet else say
        settings = CameraSettings(name=camera, size=size, rate=fps, pixels=pixels, loop=loop)
        chosen = Choice(
            color=color,
            finish=finish,
            parts=parts,
            zone=zone,
            intensity=intensity,
            strength=strength,
        )
        worn = _look(chosen, base_look(look, ref, ref_face, color, quiet), preview)
        source = stack.enter_context(closing(Camera(settings, told)))
        sinks = _outputs(source, output, stream or [], virtual_camera, overwrite, told)
        if not (sinks or preview):
            raise UsageError(_NOBODY)
        shown = PreviewSink(PreviewJpeg()) if preview else None
        run = LiveRun(
            source, worn, [shown, *sinks] if shown else sinks, faces=faces, device=device, say=told
        )
        if shown:
            stack.enter_context(
                page(
                    LiveShow(run, shown, PhotoLook(Path(ref).name, worn) if ref else None),
                    Worker(),
                    host,
                    port,
                    browser=browser,
                    told=told,
                )
            )
        _until_it_ends(run, quiet)


def _silent(line: str) -> None:
    """Nobody wants to hear it."""


def _look(chosen: "Choice", base: "Look | None", preview: bool) -> "Look":
    """What to paint at first. On the page it can still be chosen; elsewhere it must be said."""
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.look.options import choose_look

    if preview and base is None and chosen.color is None and chosen.finish is None:
        base = Look()
    return choose_look(replace(chosen, base=base))


def _outputs(
    camera: "Camera",
    output: str | None,
    urls: list[str],
    virtual_camera: bool,
    overwrite: bool,
    told: Callable[[str], None],
) -> "list[LiveSink]":
    """All that the pictures go to beside the page, checked before the first comes."""
    from makeup_video.pipeline.live.sinks.recording import Recording
    from makeup_video.pipeline.live.sinks.stream import Stream
    from makeup_video.pipeline.live.sinks.virtual_camera import VirtualCamera

    sinks: list[LiveSink] = []
    if output is not None:
        sinks.append(Recording(output, overwrite=overwrite, rate=camera.rate, source=camera.path))
    sinks += [Stream(url, say=told, rate=camera.rate) for url in urls]
    if virtual_camera:
        sinks.append(VirtualCamera(rate=camera.rate))
    return sinks


def _until_it_ends(run: "LiveRun", quiet: bool) -> None:
    """Ctrl-C is the usual end. Exit code 4 when an output broke on the way, or never got a picture.

    The closing line comes in any case: what was painted until an error may be in a recording.
    """
    from makeup_video.pipeline import StoppedError

    began = time.monotonic()
    with show_live(quiet) as shown:
        try:
            run.run(lambda: shown(run.figures()))
        except (StoppedError, KeyboardInterrupt):
            pass
        finally:
            if not quiet:
                say(live_summary(run.figures(), time.monotonic() - began))
    if quiet:  # else each was told when it came
        for error in run.failures:
            say(f"{type(error).__name__}: {error.spelled(option_of_command)}")
    for error in run.failures:
        raise typer.Exit(error.exit_code)
