"""Requests of the page that fail, are refused, or get no answer."""

import json

import pytest
from makeup_video.pipeline.look.ready import ready_looks
from people import SAMPLES

READY = len(ready_looks())
# Long times, after which a request is given up, pass a hundred times as fast.
FAST = """
    const [timer, timeout] = [window.setTimeout, AbortSignal.timeout];
    window.setTimeout = (call, ms) => timer(call, ms > 60_000 ? ms / 100 : ms);
    AbortSignal.timeout = (ms) => timeout.call(AbortSignal, ms / 100);
"""


@pytest.fixture
def page(demo, visit):
    return visit(demo)


def test_a_catalogue_that_gets_no_answer_is_given_up(page, tmp_path):
    page.page.evaluate(FAST)
    page.page.route("**/shades?*", lambda route: None)  # never answered
    (tmp_path / "shades.csv").write_text("brand,product,shade,hex\nA,B,C,#102030\n")
    page.drop(tmp_path / "shades.csv")
    page.until(lambda: "shades.csv could not be sent: " in page.page.inner_text("#error"))


def test_a_photo_that_gets_no_answer_is_given_up(page):
    page.page.evaluate(FAST)
    page.page.route("**/photo?*", lambda route: None)
    page.drop(SAMPLES / "look.jpg", ".target[data-kind=photo]")
    error = page.page.locator("#photo-slot .error")
    page.until(lambda: error.inner_text().startswith("look.jpg could not be sent: the server"))
    assert page.page.get_attribute("#photo-slot", "aria-busy") == "false"


def test_a_picture_that_gets_no_answer_is_given_up(page):
    page.page.evaluate(FAST)
    page.page.route("**/picture.png?*", lambda route: None)
    page.page.click("#save-picture")
    page.until(lambda: "picture could not be saved: " in page.page.inner_text("#error"))


def test_a_page_refused_on_reconnecting_says_so_quietly(page):
    sockets = []

    def connect(socket):
        sockets.append(socket)
        if len(sockets) == 1:
            socket.connect_to_server()
            return
        socket.send(json.dumps({"type": "error", "text": "too many pages"}))
        socket.close()

    page.page.route_web_socket("**/ws*", connect)
    page.page.reload()
    page.until(lambda: page.pts is not None)
    sockets[0].close()
    page.until(lambda: len(sockets) > 3)
    page.until(lambda: page.page.inner_text("#veil") == "too many pages")
    assert page.page.inner_text("#error") == ""


def test_the_row_of_looks_comes_after_a_failed_answer(page):
    page.server_may_stop = True
    page.page.add_init_script(FAST)
    answers = [{"status": 503, "body": '{"error": "busy"}'}, {"status": 503, "body": "no JSON"}]
    page.page.route(
        "**/looks", lambda route: route.fulfill(**answers.pop()) if answers else route.continue_()
    )
    page.page.reload()
    page.until(lambda: page.page.locator("#ready .thumbs button").count() == READY)
    assert not answers


def test_a_thumbnail_comes_after_a_failed_answer(page):
    page.server_may_stop = True
    page.page.route("**/look-thumbnail?*", lambda route: route.fulfill(status=503))
    page.page.reload()
    drawn = page.page.locator("#ready img:not([hidden])")
    page.until(lambda: page.page.locator("#ready .thumbs button").count() == READY)
    page.page.wait_for_load_state("networkidle")
    assert drawn.count() == 0
    page.page.unroute("**/look-thumbnail?*")
    page.page.fill("#lips-panel .hex", "#102030")
    page.page.click("#keep-look")  # draws what is missing
    page.until(lambda: drawn.count() == READY + 1)


CAMERAS = {
    "is_owner": True,
    "names": ["/dev/video0", "/dev/video1"],
    "name": "/dev/video0",
    "sizes": ["1280x720", "640x480"],
    "size": "1280x720",
}
SHOW = """() => import("/static/camera.js").then(({ showCameras }) =>
    showCameras("", () => {}, (text) => (document.title = text)))"""


@pytest.fixture
def camera(page):
    """(page, its choice of a camera, the answer to a change; without one the change fails)."""
    answer = {}

    def respond(route):
        if route.request.method == "GET":
            route.fulfill(json=CAMERAS)
        elif answer:
            route.fulfill(json={**CAMERAS, **answer})
        else:
            route.abort()

    page.server_may_stop = True
    page.page.route("**/camera?*", respond)
    page.page.evaluate(SHOW)
    choice = page.page.locator("#camera [name=camera]")
    choice.focus()
    return page, choice, answer


def test_a_page_elsewhere_hides_the_choice_of_cameras(page):
    thrown = []
    debugger = page.context.new_cdp_session(page.page)
    debugger.on("Debugger.paused", lambda event: thrown.append(event["data"]["description"]))
    debugger.on("Debugger.paused", lambda _: debugger.send("Debugger.resume"))
    debugger.send("Debugger.enable")
    debugger.send("Debugger.setPauseOnExceptions", {"state": "all"})  # those that are caught, too
    page.page.route("**/camera?*", lambda route: route.fulfill(json={"is_owner": False}))
    page.page.evaluate(SHOW)
    assert thrown == [] and not page.page.is_visible("#camera")


def test_the_focus_stays_on_the_camera_that_is_chosen(camera):
    page, choice, answer = camera
    answer["name"] = "/dev/video1"
    page.page.evaluate("() => (document.querySelector('#camera select').dataset.old = 'yes')")
    choice.select_option("/dev/video1")
    page.until(lambda: choice.get_attribute("data-old") is None)
    assert choice.input_value() == "/dev/video1"
    assert choice.evaluate("(select) => select === document.activeElement")


def test_only_a_size_that_is_chosen_is_asked_for(camera):
    page, choice, answer = camera
    answer["name"] = "/dev/video1"
    sizes = page.page.locator("#camera [name=size]")
    for change, size in ((choice, ""), (sizes, "640x480")):
        with page.page.expect_request("**/camera?*") as request:
            change.select_option(size or "/dev/video1")
        assert f"&size={size}" in request.value.url and request.value.url.endswith(f"size={size}")
        # a page that does not know of another page's choice must not switch the camera back
        assert f"&name={'' if size else '%2Fdev%2Fvideo1'}&" in request.value.url
        page.until(lambda: choice.input_value() == "/dev/video1")


def test_a_camera_without_an_answer_leaves_the_former_one(camera):
    page, choice, _ = camera
    choice.select_option("/dev/video1")
    page.until(lambda: page.page.title().startswith("The camera could not be changed"))
    assert choice.input_value() == "/dev/video0"


SAVE = "#save-picture", "**/picture.png?*"
BOTH = "#save-both", "**/picture.png?*"
ON_ME = "#on-me", "**/portrait?*"


@pytest.mark.parametrize("button, address", [SAVE, BOTH, ON_ME])
def test_impatient_clicks_ask_only_once(page, button, address):
    asked = []
    page.page.route(address, lambda route: asked.append(route))
    page.until(lambda: page.page.is_visible("#ready"))
    page.page.eval_on_selector(button, "(one) => (one.hidden = false)")
    for _ in range(3):
        page.page.click(button)
        page.page.wait_for_timeout(50)
    assert len(asked) == 1
    assert page.page.get_attribute(button, "aria-busy") == "true"
    asked.pop().fulfill(status=422, json={"error": "not now"})
    page.until(lambda: page.page.get_attribute(button, "aria-busy") == "false")
    assert page.page.inner_text("#error") == "not now"
    page.page.click(button)
    page.until(lambda: asked)
    asked.pop().fulfill(status=422, json={"error": "not now"})
