"""Modules of the page alone, in a browser: messages, looks, pictures and notices."""

import pytest
from makeup_video.pipeline.look.ready import ready_looks

LOOKS = [ready.look.to_dict() for ready in ready_looks()[:2]]


@pytest.fixture
def page(demo, visit):
    return visit(demo)


# A notice of the page ends by its timer, beside one of the run. The notice of the run is closed,
# then another one of the page. Then all timers end.
CLOSED = """async () => {
    const { showFigures, tell } = await import("/static/status.js");
    const timers = [];
    window.setTimeout = (call) => timers.push(call);
    tell("several files");
    showFigures({ fps: 30, level: 0, viewers: 1, sinks: [], notice: "too dark" });
    timers.shift()();
    document.querySelector("#notice button").click();
    tell("one more file");
    const said = document.querySelector("#said").textContent;
    document.querySelector("#notice button").click();
    for (let at = 0; at < 3; at++) timers.shift()?.();
    return said;
}"""


def test_a_notice_of_the_run_that_is_closed_stays_closed(page):
    assert page.page.evaluate(CLOSED) == "one more file"
    assert not page.page.is_visible("#notice")
    assert page.page.text_content("#said") == ""


# Pictures come to a page that draws nothing; then the page draws. Returns which pictures were
# acknowledged before and after drawing.
HIDDEN = """async () => {
    const { Picture } = await import("/static/picture.js");
    const refreshes = [];
    window.requestAnimationFrame = (call) => refreshes.push(call);
    const canvas = document.createElement("canvas");
    const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg"));
    const data = new Uint8Array(await blob.arrayBuffer());
    const seen = [];
    const picture = new Picture(canvas, (pts) => seen.push(pts), () => {}, () => {});
    const rest = () => new Promise((resolve) => setTimeout(resolve, 100));
    for (const pts of [1, 2, 3, 4, 5]) {
        picture.show({ pts, rotation: 0, isVideo: false, painted: { data }, before: null });
        await rest();
    }
    const hidden = [...seen];
    while (refreshes.length) {
        refreshes.shift()();
        await rest();
    }
    return [hidden, seen.sort()];
}"""


def test_a_hidden_page_acknowledges_no_picture(page):
    hidden, seen = page.page.evaluate(HIDDEN)
    assert hidden == []
    assert seen == [1, 2, 3, 4, 5]


# What is sent before hello and after it, on a connection that is open.
BEFORE_HELLO = """async (type) => {
    const { Connection } = await import("/static/connection.js");
    const sent = [];
    let socket = null;
    window.WebSocket = class {
        static OPEN = 1;
        readyState = 1;
        constructor() { socket = this; }
        send(text) { sent.push(JSON.parse(text).type); }
    };
    const connection = new Connection({});
    const before = [connection.isUp, connection.send({ type: "early" })];
    socket.onmessage({ data: JSON.stringify({ type: "hello", session: "a", mode: "live" }) });
    return [before, [connection.isUp, connection.send({ type: "late" })], sent];
}"""


def test_nothing_is_sent_before_the_server_has_said_hello(page):
    before, after, sent = page.page.evaluate(BEFORE_HELLO)
    assert (before, after, sent) == ([False, False], [True, True], ["late"])


# Whether an edit counts as unconfirmed before the screen's refresh, after it, and once it has arrived.
EDITED = """async ([look]) => {
    const { LookStore } = await import("/static/look.js");
    const store = new LookStore(() => true);
    store.start(look, null);
    store.edit((copy) => (copy.strength = 0.5));
    const states = [store.isUnconfirmed];
    await new Promise(requestAnimationFrame);
    states.push(store.isUnconfirmed);
    store.confirm(1);
    return [...states, store.isUnconfirmed];
}"""


def test_an_edit_is_unconfirmed_until_it_has_arrived(page):
    assert page.page.evaluate(EDITED, LOOKS) == [True, True, False]


# How many values are written as text when looks are compared, for the first time and again.
COMPARED = """async ([one, other]) => {
    const { sameLook } = await import("/static/look.js");
    const write = JSON.stringify;
    let count = 0;
    JSON.stringify = (...values) => {
        count += 1;
        return write(...values);
    };
    const counts = [0, 1].map(() => {
        count = 0;
        if (sameLook(one, other)) throw new Error("these looks differ");
        return count;
    });
    JSON.stringify = write;
    return counts;
}"""


def test_a_look_is_compared_without_being_written_anew(page):
    first, again = page.page.evaluate(COMPARED, LOOKS)
    assert first > 0 and again == 0


# How many files are made by "Save look" on a page whose store has no look yet.
SAVED = """async () => {
    const { wireKeep } = await import("/static/keep.js");
    const { LookStore } = await import("/static/look.js");
    let count = 0;
    wireKeep(new LookStore(() => false), () => "", () => {});
    const make = URL.createObjectURL; // the page makes others, of its thumbnails
    URL.createObjectURL = () => `blob:${++count}`;
    document.getElementById("save-look").click();
    URL.createObjectURL = make;
    return count;
}"""


def test_before_the_first_look_there_is_none_to_save(page):
    assert page.page.evaluate(SAVED) == 0


# What screen readers are told, in elements that are there before their text comes.
SAID = """async (text) => {
    const { tell } = await import("/static/status.js");
    const rendered = document.querySelector("#said").checkVisibility();
    tell(text);
    return [rendered, document.querySelector("#said").textContent];
}"""


# The veil comes and goes. Its text is in a status element that is there before.
VEILED = """async (text) => {
    const { showVeil } = await import("/static/status.js");
    const status = document.querySelector("#veil").closest("[role=status]");
    const said = [status.checkVisibility(), status.innerText];
    showVeil(text);
    said.push(status.innerText.trim());
    showVeil(null);
    return [...said, status.checkVisibility(), status.innerText];
}"""


def test_the_veil_is_said_by_an_element_that_is_always_there(page):
    assert page.page.evaluate(VEILED, "no frame") == [True, "", "no frame", True, ""]
    page.page.click("#picture")  # the empty element is not in the way


def test_a_notice_is_said_by_an_element_that_is_always_there(page):
    assert page.page.evaluate(SAID, "several files") == [True, "several files"]
    page.page.click("#notice button")
    assert page.page.text_content("#said") == ""
    status = page.page.locator("#panel > [role=status]")
    assert status.evaluate("(one) => one.checkVisibility()")
    assert not page.page.is_visible("#look-words")
    page.until(lambda: page.page.is_visible("#ready"))
    photos, looks = (page.page.locator(one).bounding_box() for one in ("#photos", "#ready"))
    assert looks["y"] - photos["y"] - photos["height"] == 12  # the empty element takes no room
