"""`makeup-video live --ref look.jpg`: paint a look on a camera's picture as it arrives."""

import os
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import log
from makeup_video.cli.look_options import LookOptions, log_changes
from makeup_video.cli.options import (
    CAMERA,
    OUTPUT,
    PAGE,
    Debug,
    Overwrite,
    PageOptions,
    Quiet,
    with_options,
)
from makeup_video.cli.outcome import error_line, report_errors, settle_kernels

if TYPE_CHECKING:
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.live.interfaces import LiveSink
    from makeup_video.pipeline.live.run import LiveRun
    from makeup_video.pipeline.live.sinks.recording import Recording
    from makeup_video.pipeline.live.sound import LiveSound, SoundTap
    from makeup_video.pipeline.live.sources.switch import CameraSwitch
    from makeup_video.pipeline.look.options import Choice

EXAMPLES = (
    "makeup-video live --look cat-eye",
    "makeup-video live --ref look.jpg -o talk.mkv",
    "makeup-video live --camera talk.mp4 --loop",
)
_NO_OUTPUT = (
    "--no-preview leaves no output: add -o OUT, --stream URL or --virtual-camera, or leave it out"
)


@with_options
def live(
    look: LookOptions,
    page: PageOptions,
    camera: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="A camera, or a video played as one; default: the first camera.",
            rich_help_panel=CAMERA,
        ),
    ] = None,
    size: Annotated[
        str,
        typer.Option(
            metavar="WxH", help="Size to request from the camera.", rich_help_panel=CAMERA
        ),
    ] = "1280x720",
    fps: Annotated[
        int,
        typer.Option(
            metavar="N", help="Frame rate to request from the camera.", rich_help_panel=CAMERA
        ),
    ] = 30,
    pixels: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="mjpeg or yuyv422, asked of the camera; default: mjpeg if offered, not on macOS.",
            rich_help_panel=CAMERA,
        ),
    ] = None,
    loop: Annotated[
        bool,
        typer.Option("--loop", help="Start a video again when it ends.", rich_help_panel=CAMERA),
    ] = False,
    audio: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="A microphone, file (the audio of the video) or none; default: the audio of the "
            "video, or the first microphone.",
            rich_help_panel=CAMERA,
        ),
    ] = None,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="OUT", help="Record into this file.", rich_help_panel=OUTPUT
        ),
    ] = None,
    overwrite: Overwrite = False,
    stream: Annotated[
        list[str] | None,
        typer.Option(
            metavar="URL",
            help="Send to rtmp://, rtmps://, srt:// or udp://; may be repeated.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    virtual_camera: Annotated[
        bool,
        typer.Option(
            "--virtual-camera",
            help="Act as a camera for other programs (needs makeup-video[virtualcam]).",
            rich_help_panel=OUTPUT,
        ),
    ] = False,
    preview: Annotated[
        bool, typer.Option(help="Show the result in the browser.", rich_help_panel=PAGE)
    ] = True,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Paint a look on a camera's picture, for the browser, a file, a stream, a virtual camera."""
    from makeup_video.cli.serve_page import serve_page
    from makeup_video.pipeline import UsageError
    from makeup_video.pipeline.images.jpeg import PreviewJpeg
    from makeup_video.pipeline.live.preview_video import PreviewVideo
    from makeup_video.pipeline.live.run import LiveRun
    from makeup_video.pipeline.live.sources.camera import CameraSettings
    from makeup_video.pipeline.live.sources.switch import CameraSwitch
    from makeup_video.web.live_session import LiveShow
    from makeup_video.web.preview_sink import PreviewSink
    from makeup_video.web.read_look import look_of_file
    from makeup_video.web.slow_jobs import SlowJobs

    with report_errors("live", debug=debug), ExitStack() as stack:
        log_line = _discard if quiet else log
        settings = CameraSettings(name=camera, size=size, rate=fps, pixels=pixels, loop=loop)
        base = look.base_look(quiet)
        first = _first_look(look.choice(), base, preview)
        if base is not None and look.ref is not None and not quiet:
            log_changes(base, first)
        source = stack.enter_context(closing(CameraSwitch(settings, log_line)))
        sound = _Sound(source, lambda: _opened_sound(source, audio, log_line))
        stack.callback(sound.close)
        sinks = _outputs(source, output, stream or [], virtual_camera, overwrite, log_line, sound)
        if not (sinks or preview):
            raise UsageError(_NO_OUTPUT)
        video = PreviewVideo if PreviewVideo.is_available() else None
        shown = PreviewSink(PreviewJpeg(), video, log_line) if preview else None
        settle_kernels(quiet)
        run = LiveRun(
            source,
            first,
            [shown, *sinks] if shown else sinks,
            faces=look.faces,
            device=look.device,
            log=log_line,
        )
        if shown:
            photo = look_of_file(look.ref, first) if look.ref else None
            show = LiveShow(run, shown, photo, lambda: _recording(source, sound), source)
            stack.enter_context(serve_page(show, SlowJobs(), page, log_line))
        _run_until_it_ends(run, quiet)


def _discard(line: str) -> None:
    """The log of a quiet run."""


def _first_look(choice: "Choice", base: "Look | None", preview: bool) -> "Look":
    """The look to begin with; it is bare if no option gives a look and there is a page.

    Raises UsageError when there is neither a look nor a page to choose one on.
    """
    from makeup_video.pipeline import Look
    from makeup_video.pipeline.look.options import choose_look

    if preview and base is None and not (choice.color or choice.finish or choice.worn):
        base = Look()
    return choose_look(replace(choice, base=base))


def _outputs(
    camera: "CameraSwitch",
    output: str | None,
    urls: list[str],
    virtual_camera: bool,
    overwrite: bool,
    log_line: Callable[[str], None],
    sound: "_Sound",
) -> "list[LiveSink]":
    """Every output but the page, checked before the first frame arrives."""
    from makeup_video.pipeline.live.sinks.recording import Recording
    from makeup_video.pipeline.live.sinks.stream import Stream
    from makeup_video.pipeline.live.sinks.virtual_camera import VirtualCamera

    sinks: list[LiveSink] = []
    if output is not None:
        tap = sound.tap()
        sinks.append(
            Recording(output, overwrite=overwrite, rate=camera.rate, source=camera.path, sound=tap)
        )
    sinks += [Stream(url, log=log_line, rate=camera.rate, sound=sound.tap()) for url in urls]
    if virtual_camera:
        sinks.append(VirtualCamera(rate=camera.rate))
    return sinks


class _Sound:
    """The run's sound, opened by the first output that takes sound.

    A microphone is open only while something records or streams it.
    """

    def __init__(self, camera: "CameraSwitch", opened: "Callable[[], LiveSound | None]") -> None:
        self._camera, self._open = camera, opened
        self._sound: LiveSound | None = None
        self._is_open = False
        self._opened_for: tuple[Path, int] | None = None

    def tap(self, again: bool = False) -> "SoundTap | None":
        """A tap that gives one output the sound; None if there is none.

        again: if there was none, try once more: a microphone that was busy may be free by now.
        Raises InputError, UsageError.
        """
        camera = self._camera
        # The page may choose another camera, or the same file again, which then starts over.
        playing = None if camera.path is None else (camera.path, camera.changes)
        if self._is_open and self._opened_for == playing:
            tap = None if self._sound is None else self._sound.tap()
            if tap is not None or (self._sound is None and not again):
                return tap
        self.close()
        self._sound, self._is_open, self._opened_for = self._open(), True, playing
        return None if self._sound is None else self._sound.tap()

    def close(self) -> None:
        if self._sound is not None:
            self._sound.close()
        self._sound, self._is_open = None, False


def _recording(camera: "CameraSwitch", sound: _Sound) -> "Recording":
    """Begin a recording for the page, in the folder where the command runs."""
    from makeup_video.pipeline.files.output_file import part_path
    from makeup_video.pipeline.live.sinks.recording import Recording

    begun, taken = time.strftime("makeup-%Y%m%d-%H%M%S"), set(os.listdir())
    names = chain([f"{begun}.mkv"], (f"{begun}-{number}.mkv" for number in count(2)))
    name = next(name for name in names if not taken & {name, part_path(Path(name)).name})
    tap = sound.tap(again=True)
    try:
        return Recording(name, rate=camera.rate, source=camera.path, sound=tap)
    except BaseException:
        if tap is not None:
            tap.close()
        raise


def _opened_sound(
    camera: "CameraSwitch", name: str | None, log_line: Callable[[str], None]
) -> "LiveSound | None":
    """Open the sound for the outputs; None if there is none. Raises InputError, UsageError.

    If no name is given and the machine has no microphone, one line logs that there is no sound.
    """
    from makeup_video.pipeline import InputError, UsageError
    from makeup_video.pipeline.live.sound import LiveSound, SoundSource
    from makeup_video.pipeline.live.sources.microphone import Microphone

    if name == "none":
        return None
    source: SoundSource | None
    if name == "file" or (name is None and camera.path is not None):
        source = camera.file_sound()
        if source is None and name == "file":
            raise UsageError("--audio file needs a video with audio as --camera")
        if source is None:
            return None  # the summary says so at the end
    else:
        try:
            source = Microphone(name, log_line)
        except InputError as error:
            if name is not None:
                raise
            log_line(f"{error}; the outputs have no audio")
            return None
        log_line(f"the audio comes from the microphone {source.name}; --audio none turns it off")
    sound = LiveSound(source, log_line, while_tapped=isinstance(source, Microphone))
    sound.start()
    return sound


def _run_until_it_ends(run: "LiveRun", quiet: bool) -> None:
    """Run until Ctrl-C, which is the usual end, or until the camera ends.

    The summary is logged even after an error, since a recording may hold what was painted until
    then. Raises typer.Exit with the exit code of the first output that failed or never got a
    picture.
    """
    from makeup_video.cli.main import mark_output_whole
    from makeup_video.cli.progress import live_summary, show_live
    from makeup_video.pipeline import StoppedError

    began = time.monotonic()
    with show_live(quiet) as show:
        try:
            run.run(lambda: show(run.figures()))
        except (StoppedError, KeyboardInterrupt):
            pass
        finally:
            mark_output_whole()  # another Ctrl-C must not change the exit code
            if not quiet:
                log(live_summary(run.figures(), time.monotonic() - began))
    if failures := run.failures:
        if quiet:  # otherwise each failure was logged when it happened
            for error in failures:
                log(error_line(error, "live"))
        raise typer.Exit(failures[0].exit_code)
