"""Write the README's screenshot of `makeup-video live` on the sample video with a ready look.

    python docs/make/make_live_picture.py

The script needs Chromium, the extra `test`, and a machine without other work. On two cores without
a GPU, the page says all the time that the machine is slow, and the picture shows this.
"""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import contact_sheet as sheet
import cv2
import numpy as np
from makeup_video.benchmark.live_browser import find_browser
from makeup_video.pipeline import find_faces

LIVE = "live.jpg"
PICTURES = {LIVE: lambda: draw()}
_SIZE = {"width": 1280, "height": 800}
_LOOK = "smoky brown"  # as its thumbnail names it; it has several layers of eyeshadow
_HAS_THUMBNAILS = """() => [...document.querySelectorAll("#ready img")]
    .every((one) => !one.hidden)"""
_PAUSE_MS = 1_500  # a screenshot delays the page, and its figures show the delay for a while
# Without a GPU the browser needs more CPU time than the run, and the run must keep its pace.
_NICE = 15
_ALARM = "#figures .alarming"  # a slow machine, or a long delay
_MOST_SECONDS = 60
_SETTLED_MS = 12_000  # by then the page no longer shows the messages of the first seconds


def draw() -> np.ndarray:
    """Return a screenshot with the divider on the face, (H, W, 3) uint8, encoded as sRGB."""
    from playwright.sync_api import sync_playwright

    with _live() as url, sync_playwright() as playwright:
        os.nice(_NICE)
        browser = playwright.chromium.launch(
            executable_path=find_browser(), args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page(viewport=_SIZE)
        page.goto(url)
        page.wait_for_selector("#picture[data-pts]")
        page.wait_for_selector("#ready img")
        page.wait_for_function(_HAS_THUMBNAILS)
        page.click(f"#ready button:has-text('{_LOOK}')")
        page.click("#eyes-tab")
        page.click("#compare-button")
        page.wait_for_timeout(_SETTLED_MS)
        if page.is_visible("#notice button"):  # about this machine, which may have other work
            page.click("#notice button")
        box = page.locator("#divider").bounding_box()
        middle_x, until = box["x"] + box["width"] / 2, time.monotonic() + _MOST_SECONDS
        while True:
            is_calm = not page.is_visible(_ALARM)
            if (is_calm or time.monotonic() > until) and _poses(picture := _shot(page), middle_x):
                browser.close()
                if not is_calm:
                    print("the picture shows an alarm: end other programs first", file=sys.stderr)
                return picture
            page.wait_for_timeout(_PAUSE_MS)


def _poses(rgb8: np.ndarray, middle_x: float) -> bool:
    """Tell whether the nose is at middle_x, the mouth not wide open and the eyes not closed."""
    points = find_faces(rgb8)[0].points_px
    nose_x, open_px = points[4, 0], points[14, 1] - points[13, 1]
    lids_px = points[374, 1] - points[386, 1]
    return bool(abs(nose_x - middle_x) < 12 and open_px < 20 and lids_px > 6)


def _shot(page: Any) -> np.ndarray:
    data = np.frombuffer(page.screenshot(), np.uint8)
    return np.ascontiguousarray(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1])


@contextmanager
def _live() -> Iterator[str]:
    """Run `makeup-video live` while the block runs, and yield the address of the page."""
    video = str(sheet.SAMPLES / "in.mp4")
    command = [sys.executable, "-m", "makeup_video", "live", "--camera", video, "--loop"]
    process = subprocess.Popen(
        [*command, "--port", "0", "--no-browser"], stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stderr is not None
        yield next(found[0] for line in process.stderr if (found := re.search(r"http://\S+", line)))
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


if __name__ == "__main__":
    sheet.take_no_options(__doc__)
    sheet.save_all(PICTURES)
