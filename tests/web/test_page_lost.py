"""A peer that is lost without a close, and a server that is started anew."""

import signal

from browser import Served
from people import SAMPLES


def is_recording(page):
    return page.page.get_attribute("#record-button", "aria-pressed") == "true"


def test_before_a_camera_a_silent_peer_counts_as_lost(chromium, camera_clip, visit, tmp_path):
    live = Served("live", "--camera", str(camera_clip), "--loop", folder=tmp_path)
    demo = Served("demo")
    camera, portrait = visit(live), visit(demo)
    camera.page.click("#record-button")
    camera.until(lambda: is_recording(camera))
    for served in (live, demo):
        served.process.send_signal(signal.SIGSTOP)  # its sockets stay open
    try:
        camera.until(lambda: "connection was lost" in camera.page.inner_text("#veil"))
        assert not is_recording(camera)
        portrait.page.wait_for_timeout(1500)
        assert not portrait.page.is_visible("#veil")  # a portrait is silent until it changes
    finally:
        for served in (live, demo):
            served.process.send_signal(signal.SIGCONT)
    camera.until(lambda: not camera.page.is_visible("#veil"))
    camera.wait_for_pictures(5)
    camera.until(lambda: is_recording(camera))
    for page, served in ((camera, live), (portrait, demo)):
        page.server_may_stop = True
        assert served.stop() == 0, served.lines


def test_a_restart_is_no_step_and_another_mode_reloads(chromium, camera_clip, visit):
    first = Served("demo")
    page = visit(first)
    page.server_may_stop = True
    before = page.look()
    page.page.fill("#lips-panel .hex", "#102030")
    mine = page.look()
    assert first.stop() == 0
    page.until(lambda: page.page.is_visible("#veil"))
    second = Served("demo", port=first.port)
    page.until(lambda: not page.page.is_visible("#veil"))
    assert page.look() == mine
    page.page.click("#undo")
    assert page.look() == before
    assert page.page.get_attribute("#undo", "aria-disabled") == "true"
    assert second.stop() == 0
    page.until(lambda: page.page.is_visible("#veil"))
    live = Served("live", "--camera", str(camera_clip), "--loop", port=first.port)
    page.until(lambda: page.page.get_attribute("body", "data-mode") == "live")
    page.until(lambda: page.page.locator("#portrait-slot").count() == 0)
    page.until(lambda: page.pts is not None)
    assert live.stop() == 0, live.lines


def test_after_a_restart_the_photo_is_still_that_of_the_look(chromium, visit):
    arguments = "demo", "--ref", str(SAMPLES / "look.jpg")
    first = Served(*arguments)
    page = visit(first)
    page.server_may_stop = True
    page.until(lambda: "look.jpg" in page.page.inner_text("#photo-slot b"))
    page.drop(SAMPLES / "look.jpg", ".target[data-kind=photo]", name="evening.jpg")
    page.until(lambda: "evening.jpg" in page.page.inner_text("#photo-slot b"))
    assert first.stop() == 0
    page.until(lambda: page.page.is_visible("#veil"))
    second = Served(*arguments, port=first.port)
    page.until(lambda: not page.page.is_visible("#veil"))
    assert "evening.jpg" in page.page.inner_text("#photo-slot b")
    assert page.page.is_visible("#look-words")
    assert second.stop() == 0
