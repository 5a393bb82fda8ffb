"""Recording from the page, notices that are closed, and looks on one's own face."""

import re

import numpy as np
import pytest
from browser import PHONE, Served
from claps import clap_clip, marks


@pytest.fixture
def live(chromium, camera_clip, tmp_path):
    served = Served("live", "--camera", str(camera_clip), "--loop", folder=tmp_path)
    yield served
    assert served.stop() == 0, served.lines


def figures(page):
    return page.page.inner_text("#figures")


def recorded_s(page):
    """How long the recording has run; -1 for none. A busy machine may show no single second."""
    shown = re.search(r"REC (\d+):(\d\d)", figures(page))
    return 60 * int(shown[1]) + int(shown[2]) if shown else -1


def test_a_recording_is_started_and_stopped_with_its_sound(chromium, visit, tmp_path):
    clip = clap_clip(tmp_path / "clap.mp4", 3)
    served = Served("live", "--camera", str(clip), "--loop", folder=tmp_path)
    page = visit(served, **PHONE)
    page.page.click("#record-button")
    page.until(lambda: recorded_s(page) >= 4)
    assert page.page.get_attribute("#record-button", "aria-pressed") == "true"
    page.page.click("#record-button")
    page.until(lambda: "REC" not in figures(page))
    (path,) = page.until(lambda: list(tmp_path.glob("makeup-*[0-9].mkv")))
    assert "part" not in path.name
    page.until(lambda: page.page.inner_text("#notice").startswith(f"{path.name} (0:0"))
    assert "was saved in the folder where makeup-video was started" in page.page.inner_text(
        "#notice"
    )
    flashes, claps = marks(path)
    assert len(flashes) >= 1
    for flash in flashes[:-1]:  # the recording may end between a flash and its clap
        assert min(abs(clap - flash) for clap in claps) < 0.020
    page.server_may_stop = True
    assert served.stop() == 0
    assert f"{path.name} got" in served.lines[-1] and "audio from clap.mp4" in served.lines[-1]


def test_two_presses_in_a_row_start_and_stop_a_recording(live, visit, tmp_path):
    page = visit(live)

    def are_begun(count):
        return lambda: len(list(tmp_path.glob("makeup-*.mkv"))) == count

    for count, is_on in ((1, "true"), (1, "false"), (2, "true"), (2, "false")):
        page.page.click("#record-button")
        pressed = "document.getElementById('record-button').ariaPressed"
        page.page.wait_for_function(f"() => {pressed} === '{is_on}'", timeout=2000)
        page.until(are_begun(count))  # a recording stopped before its first frame leaves no file
    page.until(lambda: len(list(tmp_path.glob("makeup-*.mkv"))) == 2)
    page.page.wait_for_timeout(700)
    assert "REC" not in figures(page)
    assert page.page.inner_text("#error") == ""


def test_a_double_click_starts_a_recording_and_leaves_it(live, visit, tmp_path):
    page = visit(live)
    page.page.dblclick("#record-button")
    page.until(lambda: recorded_s(page) >= 1)
    page.page.click("#record-button")
    page.until(lambda: "was saved in the folder" in page.page.inner_text("#notice"))
    assert len(list(tmp_path.glob("makeup-*.mkv"))) == 1


def test_the_user_s_recording_is_not_taken_for_the_page_s(chromium, camera_clip, visit, tmp_path):
    command = ["live", "--camera", str(camera_clip), "--loop"]
    served = Served(*command, "-o", "makeup-20260101-101010.mkv", folder=tmp_path)
    page = visit(served)
    page.until(lambda: "REC" in figures(page))
    assert page.page.get_attribute("#record-button", "aria-pressed") == "false"
    with page.page.expect_response("**/recording?*"):  # until then the button is busy
        page.page.click("#record-button")
    page.until(lambda: figures(page).count("REC") == 2)
    page.page.click("#record-button")
    page.until(lambda: "was saved in the folder" in page.page.inner_text("#notice"))
    assert figures(page).count("REC") == 1
    page.server_may_stop = True
    assert served.stop() == 0


# The figures before a recording, and twice after one that ended without a frame.
NOTHING = """() => import("/static/status.js").then(({ showFigures }) => {
    const sink = {
        kind: "recording", name: "makeup-20260101-101010.mkv", pictures: 0, seconds: 0, is_over: true, by_page: true,
    };
    for (const sinks of [[], [sink], [sink]]) showFigures({fps: 30, level: 0, viewers: 1, notice: "", sinks});
})"""


def test_a_recording_without_a_frame_is_said(demo, visit):
    page = visit(demo)
    page.page.evaluate(NOTHING)
    assert page.page.inner_text("#notice").startswith(
        "Nothing was recorded: the camera sent no frames"
    )


def test_the_looks_are_shown_on_whom_the_camera_sees(live, visit):
    page = visit(live)
    shown = "() => document.querySelector('#ready img:not([hidden])')?.src"
    before = page.until(lambda: page.page.evaluate(shown))
    page.page.click("#on-me")
    page.until(lambda: page.page.evaluate(shown) != before)
    assert page.page.inner_text("#error") == ""


NOTICE = """(text) => {
    const figures = {fps: 30, level: 3, level_notice: text, viewers: 1, screen_ms: 20, dropped: 0, sinks: []};
    return import("/static/status.js").then((status) => status.showFigures(figures));
}"""


def test_a_notice_lies_below_the_picture_and_is_closed(demo, visit):
    page = visit(demo, **PHONE)
    page.page.evaluate(NOTICE, "slow machine")
    notice, picture = page.page.locator("#notice"), page.page.locator("#frame")
    box = picture.bounding_box()
    assert notice.bounding_box()["y"] >= box["y"] + box["height"] - 1
    notice.get_by_role("button", name="Close this notice").click()
    assert not notice.is_visible()
    page.page.evaluate(NOTICE, "slow machine")  # still the same: it stays closed
    assert not notice.is_visible()
    page.page.evaluate(NOTICE, "slower machine")
    assert notice.inner_text().startswith("slower machine")


def test_before_a_portrait_there_is_nothing_to_record(demo, visit):
    page = visit(demo)
    assert not page.page.is_visible("#record-button")
    assert np.ptp(page.picture()) > 100
