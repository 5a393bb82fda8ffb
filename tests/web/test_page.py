"""The page in a real browser, on the real server and the real pipeline."""

import json
import re
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from browser import PHONE, Served
from makeup_video.pipeline import Look
from makeup_video.pipeline.look.kinds import PARTS
from people import SAMPLES

RED, BLUE = "#B4002E", "#1020C0"


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """Two seconds of the sample, scaled down and stored sideways as by a phone."""
    path = tmp_path_factory.mktemp("live") / "clip.mp4"
    with av.open(str(SAMPLES / "in.mp4")) as source, av.open(str(path), "w") as out:
        stream = out.add_stream("h264", rate=15, options={"crf": "16"})
        stream.width, stream.height, stream.pix_fmt = 360, 640, "yuv420p"
        stream.set_display_rotation(90)
        for number, frame in zip(range(60), source.decode(video=0), strict=False):
            if number % 2:
                continue
            lying = np.rot90(frame.to_ndarray(format="rgb24", width=640, height=360), -1)
            sideways = av.VideoFrame.from_ndarray(np.ascontiguousarray(lying), format="rgb24")
            sideways.pts = number // 2
            out.mux(stream.encode(sideways.reformat(format="yuv420p")))
        out.mux(stream.encode(None))
    return path


@pytest.fixture(scope="module")
def live(chromium, clip):
    served = Served("live", "--camera", str(clip), "--loop", "--color", RED)
    yield served
    assert served.stop() == 0, served.lines


def wear(visit, colour, finish="satin"):
    """Put on lipstick of this colour, and nothing on the eyes."""
    for region, worn in (("eyes", False), ("lips", True)):
        visit.page.click(f"#{region}-tab")
        visit.page.set_checked(f"#{region}-panel [role=switch]", worn)
    visit.page.fill("#lips-panel .hex", colour)
    visit.page.click(f"#lips-panel .finishes button:has-text('{finish}')")


def is_red(rgb):
    """Whether lips wear RED; bare lips have more green, berry lips more blue."""
    return rgb is not None and rgb[1] < 0.36 * rgb[0] and rgb[2] < 0.6 * rgb[0]


def is_blue(rgb):
    return rgb is not None and rgb[2] > 1.4 * rgb[0]


def test_the_camera_s_picture_arrives_upright_and_moves(live, visit):
    page = visit(live)
    page.wait_for_pictures(10)
    assert page.picture().shape == (360, 640, 3)  # the clip is stored lying on its side
    page.until(lambda: page.lips() is not None)
    page.until(lambda: re.search(r"\d+ fps.*\d+ ms", page.page.inner_text("#figures"), re.DOTALL))


def test_a_colour_set_on_the_page_appears_on_the_lips(live, visit):
    page = visit(live)
    wear(page, RED)
    page.until(lambda: is_red(page.lips()))
    page.page.fill("#lips-panel .hex", BLUE)
    page.until(lambda: is_blue(page.lips()))


def test_keys_alone_reach_a_slider_and_change_the_lips(demo, visit):
    page = visit(demo)
    page.until(lambda: is_red(page.lips()))
    keys = page.page.keyboard
    reached = "() => document.activeElement.labels?.[0]?.textContent ?? ''"
    for _ in range(40):
        keys.press("Tab")
        if page.page.evaluate(reached) == "Opacity":
            break
    assert page.page.evaluate(reached) == "Opacity"
    keys.press("Home")
    page.until(lambda: not is_red(page.lips()))
    keys.press("Control+z")
    page.until(lambda: is_red(page.lips()))


def test_two_pages_stay_in_step_beside_a_stalled_one(live, visit):
    first, second, stalled = visit(live), visit(live), visit(live)
    devtools = stalled.context.new_cdp_session(stalled.page)
    devtools.send("Debugger.enable")
    devtools.send("Debugger.pause")  # from here on the page reads and acknowledges nothing
    wear(first, "#20A040")
    first.until(lambda: second.page.input_value("#lips-panel .hex") == "#20A040")
    first.wait_for_pictures(20)
    second.wait_for_pictures(20)
    assert "3 viewers" in first.page.inner_text("#figures")
    devtools.send("Debugger.disable")
    wear(second, RED)
    second.until(lambda: first.page.input_value("#lips-panel .hex") == RED)
    first.until(lambda: is_red(first.lips()))


def test_a_dragged_slider_is_not_reset_by_another_page(live, visit):
    page, other = visit(live), visit(live)
    wear(page, RED)
    other.until(lambda: other.page.input_value("#lips-panel .hex") == RED)
    mine, theirs = (visitor.page.locator("#lips-panel").get_by_label for visitor in (page, other))
    gloss, mouse = mine("Gloss", exact=True), page.page.mouse
    gloss.evaluate("(one) => one.scrollIntoView({ block: 'center' })")
    box = gloss.bounding_box()
    y = box["y"] + box["height"] / 2
    mouse.move(box["x"] + box["width"] / 2, y)
    mouse.down()
    value = gloss.input_value()
    theirs("Gloss, as a number").fill("0.11")
    theirs("Opacity, as a number").fill("0.77")
    page.until(lambda: mine("Opacity", exact=True).input_value() == "0.77")
    assert gloss.input_value() == value
    mouse.move(box["x"] + box["width"], y)
    mouse.up()
    other.until(lambda: theirs("Gloss", exact=True).input_value() == "4")
    assert other.look() == page.look()


def test_a_slider_that_is_released_shows_the_newest_value(live, visit):
    page, other = visit(live), visit(live)
    wear(page, RED)
    other.until(lambda: other.page.input_value("#lips-panel .hex") == RED)
    mine, theirs = (visitor.page.locator("#lips-panel").get_by_label for visitor in (page, other))
    gloss = mine("Gloss", exact=True)
    gloss.evaluate("(one) => one.scrollIntoView({ block: 'center' })")
    box = gloss.bounding_box()
    page.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.page.mouse.down()
    theirs("Gloss, as a number").fill("0.11")
    theirs("Opacity, as a number").fill("0.66")
    page.until(lambda: mine("Opacity", exact=True).input_value() == "0.66")
    page.page.mouse.up()
    assert gloss.input_value() == "0.11"
    assert page.look() == other.look()


def test_a_dropped_photo_gives_its_look(live, visit):
    page = visit(live)
    wear(page, RED)
    page.drop(SAMPLES / "look.jpg", name="evening.jpg")
    page.until(lambda: page.page.is_visible("#look-words"))
    assert page.page.inner_text("#look-words").startswith("Read from the photo: lips")
    words = page.page.inner_text("#read-words")
    assert re.fullmatch(r"lips #\w{6}, .+; eyes #\w{6}.+", words)
    look = page.look()
    assert look.eyes is not None and look.lips.hex.lower() in words.lower()
    assert page.page.is_visible("#photo-slot img")
    page.until(lambda: not is_red(page.lips()))  # the lips turn berry
    page.page.fill("#lips-panel .hex", BLUE)
    page.page.fill("#name", "blue evening")
    page.page.click("#reset")
    assert page.look() == look and page.page.input_value("#name") == "evening"
    page.page.fill("#lips-panel .hex", BLUE)
    page.until(lambda: is_blue(page.lips()))  # the server has it
    page.until(lambda: page.page.inner_text("#changed-words") == "Changed since: lips: colour")
    page.page.reload()  # the server keeps everything
    page.until(lambda: "evening.jpg" in page.page.inner_text("#photo-slot"))
    assert page.page.inner_text("#read-words") == words
    assert page.page.input_value("#name") == "evening"
    drawn = "() => document.querySelector('#photo-slot img').naturalWidth > 0"
    page.until(lambda: page.page.evaluate(drawn))
    second = visit(live)
    second.until(lambda: second.page.evaluate(drawn))
    page.page.click("#reset")
    page.until(lambda: page.look() == look)


def test_an_unreadable_photo_shows_why_and_the_look_stays(demo, visit, tmp_path):
    page = visit(demo)
    before = page.look()
    (tmp_path / "bad.jpg").write_text("no photo")
    page.drop(tmp_path / "bad.jpg", ".target")
    page.until(lambda: "bad.jpg" in page.page.inner_text("#photo-slot .error"))
    grey = np.full((64, 64, 3), 128, np.uint8)
    cv2.imwrite(str(tmp_path / "grey.png"), grey)
    page.drop(tmp_path / "grey.png", "#portrait-slot")
    page.until(lambda: "grey.png" in page.page.inner_text("#portrait-slot .error"))
    assert page.look() == before
    assert not page.page.is_visible("#photo-slot img")


def test_a_dropped_portrait_is_painted(demo, visit, tmp_path):
    page = visit(demo)
    with av.open(str(SAMPLES / "in.mp4")) as source:
        frame = next(source.decode(video=0))
    cv2.imwrite(str(tmp_path / "her.png"), frame.to_ndarray(format="bgr24"))
    page.drop(tmp_path / "her.png", ".target[data-kind=portrait]")
    page.until(lambda: page.picture().shape[0] < page.picture().shape[1])
    page.until(lambda: is_red(page.lips()))


def test_left_of_the_divider_is_the_untouched_picture(demo, visit):
    page = visit(demo)
    page.until(lambda: is_red(page.lips()))
    page.page.keyboard.press("c")
    divider = page.page.locator("#divider")
    page.until(lambda: not is_red(page.lips(slice(15, 40))) and is_red(page.lips(slice(60, 85))))
    divider.press("End")
    page.until(lambda: not is_red(page.lips()))
    assert divider.get_attribute("aria-valuenow") == "100"
    box = page.page.locator("#frame").bounding_box()
    y = box["y"] + box["height"] / 2
    page.page.mouse.move(box["x"] + box["width"] - 2, y)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + 2, y, steps=4)
    page.page.mouse.up()
    page.until(lambda: is_red(page.lips()))
    page.page.keyboard.press("c")
    page.page.keyboard.down("b")
    page.until(lambda: not is_red(page.lips()))
    page.page.keyboard.up("b")
    page.until(lambda: is_red(page.lips()))


def test_looks_and_pictures_are_downloaded_and_a_look_loaded(demo, visit, tmp_path):
    page = visit(demo)
    wear(page, BLUE, "gloss")
    page.page.fill("#name", "my look")
    with page.page.expect_download() as download:
        page.page.click("#save-look")
    assert download.value.suggested_filename == "my look.json"
    text = Path(download.value.path()).read_text()
    Look.load(download.value.path()).save(tmp_path / "look.json")
    assert text == (tmp_path / "look.json").read_text()
    with page.page.expect_download() as download:
        page.page.click("#save-picture")
    page.until(lambda: is_blue(page.lips()))
    assert cv2.imread(str(download.value.path())).shape[2] == 3

    values = json.loads(text)
    (lips,) = values["layers"]
    given = {key: lips["product"][key] for key in list(lips["product"])[:7]} | {"red": 200}
    values["layers"] = [{"kind": "lipstick", "product": given}]
    (tmp_path / "short.json").write_text(json.dumps(values))
    page.drop(tmp_path / "short.json")
    page.until(lambda: page.page.input_value("#lips-panel .hex") == "#C820C0")
    (tmp_path / "typo.json").write_text(text.replace("gloss_detail", "glos_detail"))
    page.drop(tmp_path / "typo.json")
    page.until(lambda: "glos_detail" in page.page.inner_text("#error"))
    assert page.look().lips.red == 200


@pytest.mark.parametrize("kind", ["live", "demo"])
def test_on_a_phone_everything_fits_and_can_be_touched(kind, visit, request):
    page = visit(request.getfixturevalue(kind), **PHONE)
    for part in PARTS:
        page.page.click(f"#{part}-tab")
        page.page.set_checked(f"#{part}-panel [role=switch]", True)
        while page.page.is_visible(f"#{part}-panel .add"):  # until no more layers are allowed
            page.page.click(f"#{part}-panel .add")
        page.open_groups()
        assert page.page.evaluate("() => document.documentElement.scrollWidth") == 360
        assert too_small(page) == []


def too_small(page):
    """The names of the controls that are too small for a finger."""
    return page.page.evaluate(
        """() => [...document.querySelectorAll("button, summary, input[type=range], input[type=number], .hex, .choices label, .switch, .slot label, .button")]
            .map((one) => [one.id || one.className || one.type, one.getBoundingClientRect()])
            .filter(([, box]) => box.width > 0 && Math.min(box.width, box.height) < 40).map(([name]) => name)"""
    )


def test_the_page_shows_a_stopped_server_and_reconnects(chromium, visit):
    served = Served("demo")
    page = visit(served)
    wear(page, BLUE)
    page.until(lambda: is_blue(page.lips()))
    page.server_may_stop = True
    assert served.stop() == 0
    page.until(lambda: "was stopped" in page.page.inner_text("#veil"))
    again = Served("demo", port=served.port)
    page.until(lambda: not page.page.is_visible("#veil"))
    page.until(lambda: is_blue(page.lips()))  # the page sends its own look
    assert again.stop() == 0


def test_what_is_chosen_while_the_connection_is_lost_is_kept(chromium, visit, camera_clip):
    words = "live", "--camera", str(camera_clip), "--loop", "--look", "none"
    served = Served(*words)
    page = visit(served)
    page.server_may_stop = True
    assert served.stop() == 0
    page.until(lambda: page.page.is_visible("#veil"))
    wear(page, BLUE)
    page.page.wait_for_timeout(300)
    again = Served(*words, port=served.port)
    page.until(lambda: not page.page.is_visible("#veil"))
    page.until(lambda: is_blue(page.lips()))
    assert page.page.is_hidden("#look-words")
    assert again.stop() == 0


def test_zoomed_to_twice_the_size_nothing_covers_the_tools(demo, visit):
    page = visit(demo, viewport={"width": 640, "height": 400})
    page.page.evaluate(
        """() => import("/static/status.js").then((status) => status.showFigures(
            {fps: 30, level: 3, level_notice: "slow machine ".repeat(6), viewers: 1, sinks: []}))"""
    )
    notice, bar = (page.page.locator(one).bounding_box() for one in ("#notice", "#bar"))
    assert notice["y"] + notice["height"] <= bar["y"]
    assert page.page.evaluate("() => document.documentElement.scrollWidth") == 640
