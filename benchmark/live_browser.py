"""The page of a live run in headless Chromium, by playwright: when each picture is drawn.

    python -m makeup_video.benchmark.live_browser URL OUT.npy jpeg|h264

Prints "ready" once the page watches; ends when the server says goodbye. The page is unchanged: it
acknowledges each picture in the screen refresh that draws the picture, and that moment is noted.
"""

import shutil
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from makeup_video.pipeline.errors import InstallError

_NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
_CLOCKS = 50  # comparisons of the two clocks, of which the quickest counts
# Notes (pts in us, arrival and drawing in ms of performance.now(), bytes, 1 for H.264). The page
# also acknowledges pictures that it leaves out; those are not on the canvas and are not noted.
_OBSERVER = """(() => {
    const seen = (window.seen = { rows: [] });
    seen.isVideo = new Promise((resolve) => (seen.choose = resolve));
    seen.isOver = new Promise((resolve) => (seen.end = resolve));
    const came = new Map();
    window.WebSocket = class extends WebSocket {
        constructor(...address) {
            super(...address);
            this.addEventListener("close", () => seen.end());
            this.addEventListener("message", ({ data }) => {
                if (typeof data === "string") return;
                const head = new DataView(data);
                const isVideo = head.getUint16(10, true) & 1;
                const pts = Number(head.getBigUint64(0, true));
                came.set(pts, [performance.now(), data.byteLength, isVideo]);
            });
        }
        send(text) {
            const now = performance.now();
            super.send(text);
            const { type, on, pts_us: pts } = JSON.parse(text);
            if (type === "video" && on) seen.choose();
            if (type !== "shown") return;
            const [arrived, bytes, isVideo] = came.get(pts);
            came.delete(pts);
            if (document.getElementById("picture").dataset.pts === String(pts))
                seen.rows.push([pts, arrived, now, bytes, isVideo]);
        }
    };
})()"""

_WAIT_FOR_VIDEO = """Promise.race([
    window.seen.isVideo,
    new Promise((_, reject) => setTimeout(() => reject("this Chromium has no H.264"), 20_000)),
])"""


def find_browser() -> str | None:
    """Path of the system's Chromium; None: playwright's own Chromium.

    Raises InstallError when playwright is missing or no Chromium is found.
    """
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise InstallError(
            "a page in Chromium is measured by playwright: pip install playwright, and install "
            "Chromium (Debian's package is chromium), or run playwright install chromium"
        ) from error
    found = next((path for name in _NAMES if (path := shutil.which(name))), None)
    if found is None:
        with sync_playwright() as playwright:
            if not Path(playwright.chromium.executable_path).exists():
                raise InstallError(
                    "no Chromium was found: install it (Debian's package is chromium), or run "
                    "playwright install chromium"
                )
    return found


def watch(url: str, target: Path, kind: str) -> None:
    """Write the same table as live_viewer.watch, with the moment of drawing in the third column.

    The last row has the CPU seconds of all processes of the browser.
    """
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_browser())
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.add_init_script(_OBSERVER)
        page.goto(f"{url}/?video={kind}", wait_until="networkidle")  # thumbnails are there then
        if kind == "h264":
            page.evaluate(_WAIT_FOR_VIDEO)
        zero, began = _clock_zero(page), _cpu_seconds(browser)
        print("ready", flush=True)
        page.evaluate("window.seen.isOver")
        cpu = _cpu_seconds(browser) - began
        rows = np.array(page.evaluate("window.seen.rows"), np.float64).reshape(-1, 5)
        browser.close()
    rows = rows[rows[:, 4] == (kind == "h264")]  # the first picture may be a JPEG
    rows[:, 1:3] = zero + rows[:, 1:3] / 1000
    np.save(target, np.vstack([rows[:, :4], (0.0, cpu, 0.0, 0.0)]))


def _clock_zero(page: Any) -> float:
    """The monotonic seconds at which the page's performance.now() was 0."""
    best, zero = np.inf, 0.0
    for _ in range(_CLOCKS):
        before = time.monotonic()
        now_ms = page.evaluate("performance.now()")
        took = time.monotonic() - before
        if took < best:
            best, zero = took, before + took / 2 - now_ms / 1000
    return zero


def _cpu_seconds(browser: Any) -> float:
    session = browser.new_browser_cdp_session()
    processes = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    return float(sum(process["cpuTime"] for process in processes))


if __name__ == "__main__":
    watch(sys.argv[1], Path(sys.argv[2]), sys.argv[3])
