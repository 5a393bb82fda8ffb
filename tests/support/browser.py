"""A real browser on the real page: finds Chromium, starts `makeup-video` and observes the page."""

import atexit
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import Look, find_faces, lip_mask

# .ci/run sets this variable: there, a missing browser is a failure.
REQUIRED = os.environ.get("MAKEUP_VIDEO_BROWSER") == "required"
LEFT_OUT = "no Chromium on this machine: Debian's package is chromium"
_NAMES = ("chromium", "chromium-browser", "google-chrome")
_ARGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
PATIENCE_S = 30.0  # for two busy cores
DESK = {"viewport": {"width": 1280, "height": 800}}
PHONE = {"viewport": {"width": 360, "height": 740}, "has_touch": True, "is_mobile": True}


def executable() -> str:
    """Path of Chromium; without Chromium, skips the test, or fails it if Chromium is required."""
    found = next((path for name in _NAMES if (path := shutil.which(name))), None)
    if found is None:
        (pytest.fail if REQUIRED else pytest.skip)(LEFT_OUT)
    return found


@contextmanager
def open_browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    path = executable()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(_ARGS))
        yield browser
        browser.close()


class Served:
    """`makeup-video ARGUMENTS` in its own process, and the address it prints.

    folder: where it runs.  environment: further variables.
    """

    def __init__(
        self,
        *arguments: str,
        port: int = 0,
        folder: Path | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        command = [sys.executable, "-m", "makeup_video.cli", *arguments]
        self.process = subprocess.Popen(
            [*command, "--port", str(port), "--no-browser"],
            stderr=subprocess.PIPE,
            text=True,
            cwd=folder,
            env={**os.environ, **(environment or {})},
        )
        atexit.register(self.process.kill)  # for a test that fails before it stops the server
        self.lines: list[str] = []
        addresses: queue.Queue[str] = queue.Queue()
        self._listener = threading.Thread(target=self._listen, args=(addresses,), daemon=True)
        self._listener.start()
        self.url = addresses.get(timeout=PATIENCE_S)
        assert self.url, self.lines
        self.port = urlsplit(self.url).port or 0

    def _listen(self, addresses: queue.Queue[str]) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.append(line)
            if found := re.search(r"https?://\S+", line):
                addresses.put(found[0])
        addresses.put("")  # the process ended

    def stop(self) -> int:
        """Send Ctrl-C; returns the exit code. A traceback on stderr fails the test."""
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(PATIENCE_S)
        self._listener.join(PATIENCE_S)
        assert not any("Traceback" in line for line in self.lines), self.lines
        return code


class Visit:
    """An open page. `faults`: everything a page must not do, such as errors on the console."""

    def __init__(self, browser: Any, url: str, **context: Any) -> None:
        self.context = browser.new_context(**context)
        self.page = self.context.new_page()
        self.faults: list[str] = []
        self.server_may_stop = False
        origin = urlsplit(url).netloc
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("request", lambda request: self._asked(request.url, origin))
        self.page.goto(url)
        self.until(lambda: self.pts is not None)

    def _heard(self, message: Any) -> None:
        # The browser logs headers that have no meaning without HTTPS, and every refused request.
        # The page itself shows the error of such a request.
        known = ["status of 4", "Opener-Policy header has been ignored"] + [
            "net::ERR_",
            "status of 503",
        ] * self.server_may_stop
        if message.type in ("error", "warning") and not any(text in message.text for text in known):
            self.faults.append(message.text)

    def _asked(self, url: str, origin: str) -> None:
        if not url.startswith("blob:") and urlsplit(url).netloc != origin:
            self.faults.append(f"request to {url}")

    def until(self, holds: Callable[[], Any]) -> Any:
        """Wait until `holds` returns a true value, and return it; fails after PATIENCE_S."""
        end = time.monotonic() + PATIENCE_S
        while not (value := holds()):
            assert time.monotonic() < end, f"never came to hold; {self.faults}"
            self.page.wait_for_timeout(40)
        return value

    @property
    def pts(self) -> str | None:
        """Pts of the picture on the screen."""
        return self.page.get_attribute("#picture", "data-pts")

    def wait_for_pictures(self, count: int) -> None:
        """Wait for `count` new pictures."""
        seen = {self.pts}
        self.until(lambda: seen.add(self.pts) or len(seen) > count)

    def picture(self) -> np.ndarray:
        """(H, W, 3) uint8 RGB of the canvas."""
        url = self.page.evaluate("() => document.getElementById('picture').toDataURL('image/png')")
        import base64

        data = np.frombuffer(base64.b64decode(url.partition(",")[2]), np.uint8)
        return np.ascontiguousarray(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1])

    def lips(self, side: slice = slice(None)) -> np.ndarray | None:
        """Mean (red, green, blue) of the lips in the picture, or None without a face.
        side: the part of the lips, in columns from their left end, 0 to 100."""
        rgb8 = self.picture()
        faces = find_faces(rgb8)
        if not faces:
            return None
        rows, columns = np.nonzero(lip_mask(rgb8, faces[0]) > 0.9)
        left, right = columns.min(), columns.max()
        part = (columns - left) * 100 // max(1, right - left)
        chosen = np.isin(part, range(101)[side])
        return rgb8[rows[chosen], columns[chosen]].mean(axis=0)

    def look(self) -> Look:
        """The look as the downloaded file has it.

        Chromium now and then drops one of many downloads that follow each other within a second;
        the click is then repeated.
        """
        from playwright.sync_api import TimeoutError as NoDownload

        for _ in range(3):
            try:
                with self.page.expect_download(timeout=1000 * PATIENCE_S / 3) as download:
                    self.page.click("#save-look")
                return Look.load(download.value.path())
            except NoDownload:
                continue
        raise AssertionError(f"the look was not downloaded; {self.faults}")

    def open_groups(self) -> None:
        """Open every group of controls that can be closed."""
        self.page.evaluate(
            "() => document.querySelectorAll('details').forEach((one) => (one.open = true))"
        )

    def drop(self, path: Path, target: str = "body", name: str = "", kind: str = "") -> list[str]:
        """Drag a file over the page and drop it on `target`, as a user would.

        kind: the file's media type.  Returns what the page offered to do with it.
        """
        import base64

        offered: list[str] = self.page.evaluate(
            """([data, name, type, target]) => {
                const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
                const dataTransfer = new DataTransfer();
                dataTransfer.items.add(new File([bytes], name, { type }));
                const fire = (kind, where) => document.querySelector(where).dispatchEvent(
                    new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true }));
                fire("dragenter", "body");
                if (document.getElementById("drop").hidden) throw new Error("nothing says where to drop");
                fire("dragover", target);
                const offered = [...document.querySelectorAll("#drop .target")];
                fire("drop", target);
                return offered.map((one) => one.textContent);
            }""",
            [
                base64.b64encode(path.read_bytes()).decode(),
                name or path.name,
                kind or {".json": "application/json"}.get(path.suffix, "image/jpeg"),
                target,
            ],
        )
        return offered


@contextmanager
def visits(browser: Any) -> Iterator[Callable[..., Visit]]:
    """Opens pages, as Visit does; fails at the end if a page has faults."""
    opened: list[Visit] = []

    def open_page(url: str, **context: Any) -> Visit:
        opened.append(Visit(browser, url, **context))
        return opened[-1]

    yield open_page
    for visit in opened:
        visit.context.close()
        assert not visit.faults, visit.faults
