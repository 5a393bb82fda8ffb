"""The progress of a run: a bar on a terminal, a line every few seconds elsewhere, or nothing."""

import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from fractions import Fraction
from typing import IO, TYPE_CHECKING, Any, cast

from makeup_video.cli.console import log, printable

if TYPE_CHECKING:
    from makeup_video.pipeline.live.run import LiveFigures
    from rich.console import Console

_LINE_SECONDS = 5.0  # between two lines, so that a log file stays short


def _console() -> "Console":
    from rich.console import Console

    return Console(file=cast("IO[str]", _Terminal(sys.stderr)))


def _has_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


class _Terminal:
    """stderr, for rich to write on. When the terminal is closed, the work goes on."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream, self._is_open = stream, True

    def write(self, text: str) -> int:
        if self._is_open:
            try:
                self._stream.write(text)
            except (OSError, ValueError):
                self._is_open = False
        return len(text)

    def flush(self) -> None:
        if self._is_open:
            try:
                self._stream.flush()
            except (OSError, ValueError):
                self._is_open = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def show_progress(quiet: bool) -> Generator[Any, None, None]:
    """Yield the progress callback for process_video, or None when quiet.

    The callback also takes a title, which is shown before the number of frames.
    """
    if quiet:
        yield None
    elif _has_terminal():
        from makeup_video.pipeline.render.opencl import when_compiling

        bar = _Bar()
        try:
            with when_compiling(bar.say_compiling):
                yield bar
        finally:
            bar.close()
    else:
        yield _PlainLines()


class _PlainLines:
    """Logs a line every few seconds."""

    def __init__(self) -> None:
        self.began = self.logged = time.monotonic()
        self.title = ""

    def __call__(self, done: int, expected: int | None, rate: Fraction, title: str = "") -> None:
        now = time.monotonic()
        if title != self.title:
            self.title, self.began, self.logged = title, now, now
        if now - self.logged < _LINE_SECONDS or not done:
            return
        self.logged = now
        text = progress_text(done, expected, rate, now - self.began)
        log(f"{title}: {text}" if title else text)


class _Bar:
    """A progress bar by rich, made at the first call, so that importing rich delays no frame."""

    def __init__(self) -> None:
        self.bar: Any = None
        self.title = ""

    def __call__(self, done: int, expected: int | None, rate: Fraction, title: str = "") -> None:
        if self.bar is None or title != self.title:
            self.close()
            self.title = title
            self._open(expected)
        speed = self.bar.tasks[0].speed  # None or 0 until rich has measured it
        text = f"{speed:.0f} fps  {speed / rate:.1f}x real time" if speed else ""
        self.bar.update(self.task, completed=done, speed=text)

    def _open(self, expected: int | None) -> None:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeRemainingColumn,
        )

        self.bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[speed]}"),
            TimeRemainingColumn(),
            console=_console(),
            transient=True,
        )
        self.task = self.bar.add_task(printable(self.title), total=expected, speed="")
        self.bar.start()

    def say_compiling(self) -> None:
        say = log if self.bar is None else self._print
        say("compiling the kernels for this kind of video or picture")

    def _print(self, text: str) -> None:
        self.bar.console.print(printable(text), markup=False, highlight=False)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.stop()


def progress_text(done: int, expected: int | None, rate: Fraction, seconds: float) -> str:
    """Frames, frames/s, speed as a multiple of real time, and the time left, in one line."""
    fps = done / seconds if seconds else 0.0
    total = f"/{expected}" if expected else ""
    text = f"{done}{total} frames, {fps:.0f} fps, {fps / rate:.1f}x real time"
    if expected and fps and expected > done:
        left = round((expected - done) / fps)
        text += f", {left // 60}:{left % 60:02d} left"
    return text


@contextmanager
def show_batch(quiet: bool) -> Generator[tuple[Callable[[str], None], Callable[[str], None]]]:
    """Yield two functions for a batch: one logs a line that stays, one shows the work in hand.

    On a terminal the work in hand is one line that changes, elsewhere a line every few seconds.
    """
    if quiet:
        yield (lambda text: None), (lambda text: None)
    elif _has_terminal():
        with _console().status("") as status:
            console = status.console
            yield (
                lambda text: console.print(printable(text), markup=False, highlight=False),
                lambda text: status.update(_rich_text(text)),
            )
    else:
        yield log, _Rarely()


class _Rarely:
    """Logs a line every few seconds."""

    def __init__(self) -> None:
        self.logged = time.monotonic()

    def __call__(self, text: str) -> None:
        now = time.monotonic()
        if now - self.logged >= _LINE_SECONDS:
            self.logged = now
            log(text)


def _rich_text(text: str) -> Any:
    """A text that rich shows as it is, with no markup."""
    from rich.text import Text

    return Text(printable(text))


@contextmanager
def show_steps() -> Generator[Callable[[str], None], None, None]:
    """Yield a log for the steps of a long job: on a terminal one line that changes, else lines."""
    if not _has_terminal():
        yield log
        return
    with _console().status("") as status:
        yield lambda text: status.update(_rich_text(text))


@contextmanager
def show_live(quiet: bool) -> Generator[Any, None, None]:
    """Yield a callback that shows a live run's figures in one line, which only a terminal shows."""
    if quiet or not _has_terminal():
        yield lambda figures: None
        return
    with _console().status("") as status:
        yield lambda figures: status.update(_rich_text(live_text(figures)))


def live_text(figures: "LiveFigures") -> str:
    """Frames/s, latency, dropped frames and notices, in one line."""
    if figures.latency_ms is None:
        return figures.notice or "waiting for the first frame"
    parts = [f"{figures.fps:.0f} fps", f"latency {figures.latency_ms:.0f} ms"]
    if figures.dropped:
        parts.append(f"{figures.dropped} dropped")
    return ", ".join([*parts, *filter(None, (figures.level_notice, figures.notice))])


def live_summary(figures: "LiveFigures", seconds: float) -> str:
    """The summary in one line: how many pictures were painted, and how many each output got."""
    from makeup_video.pipeline.offline.report import frames_in_words

    fps = figures.pictures / seconds if seconds else 0.0
    count = frames_in_words(figures.pictures)
    text = f"{count} in {seconds:.1f} s, {fps:.1f} fps, {figures.dropped} dropped"
    if figures.damaged:
        text += f", {figures.damaged} damaged"
    for sink in figures.sinks:
        if sink.name != "preview":
            lost = f" ({sink.dropped} dropped)" if sink.dropped else ""
            text += f"; {sink.name} got {sink.pictures or 'none'} of them{lost}{sink.state}"
    return text
