"""What modules of the page do on a slow network, and with what was sent as a connection broke."""

import pytest
from makeup_video.pipeline.look.ready import ready_look, ready_looks

LOOKS = [ready.look.to_dict() for ready in ready_looks()[:2]]


@pytest.fixture
def page(demo, visit):
    return visit(demo)


# A page before a camera, whose sockets and clock the test moves. `after(s)` lets seconds pass
# without a message and returns whether the page still has the same socket.
CONNECTED = """
    const { Connection } = await import("/static/connection.js");
    let socket = null, second = null, open = null, pictures = 0;
    window.WebSocket = class {
        static OPEN = 1;
        readyState = 1;
        constructor() { socket = this; }
        send() {}
        close() {}
    };
    window.setInterval = (call) => (second = call);
    window.setTimeout = (call) => (open = call);
    new Connection({ lost() {}, picture: () => (pictures += 1) });
    const hello = () => {
        const message = { type: "hello", session: "a", mode: "live" };
        socket.onmessage({ data: JSON.stringify(message) });
    };
    const after = (s) => {
        const before = socket;
        open = null;
        for (let i = 0; i < s; i++) second();
        if (open === null) return true;
        open();
        hello();
        return socket === before;
    };
    const picture = () => socket.onmessage({ data: new ArrayBuffer(20) });
    hello();
"""

SLOW = """async () => {%s
    const kept = [after(6), after(9)];
    picture(); // took nine seconds
    kept.push(after(9));
    picture();
    return [kept, pictures];
}"""
NEVER = """async () => {%s
    const waited = [];
    for (let loss = 0; loss < 5; loss++) {
        let s = 1;
        while (after(1)) s += 1;
        waited.push(s);
    }
    return waited;
}"""
FAST_AGAIN = """async () => {%s
    const kept = [after(6), after(9)];
    picture();
    picture(); // right behind the other one
    return [...kept, after(6)];
}"""


def test_a_slow_picture_is_waited_for_and_the_next_one_too(page):
    assert page.page.evaluate(SLOW % CONNECTED) == [[False, True, True], 2]


def test_patience_doubles_with_each_loss_up_to_a_limit(page):
    assert page.page.evaluate(NEVER % CONNECTED) == [6, 11, 21, 41, 41]


def test_on_a_fast_network_a_loss_is_soon_noticed_again(page):
    assert page.page.evaluate(FAST_AGAIN % CONNECTED) == [False, True, False]


# Whether a look counts as confirmed: sent, after an answer to the one before, and after its own.
CONFIRMED = """async ([look, other]) => {
    const { LookStore } = await import("/static/look.js");
    const numbers = [];
    const store = new LookStore((_, n) => numbers.push(n));
    store.start(look, null);
    const seen = [store.isUnconfirmed];
    for (const strength of [0.5, 0.6]) {
        store.edit((copy) => (copy.strength = strength));
        await new Promise(requestAnimationFrame);
    }
    for (const n of numbers) {
        seen.push(store.isUnconfirmed);
        store.confirm(n);
    }
    seen.push(store.isUnconfirmed);
    store.edit((copy) => (copy.strength = 0.7));
    store.receive(other, null, 2); // of another page: ours, about to be sent, stays
    seen.push(store.look.strength, store.isUnconfirmed);
    store.receive(other, null, 3);
    seen.push(store.look.strength === other.strength, store.isUnconfirmed);
    return seen;
}"""


def test_a_look_is_unconfirmed_until_the_server_has_it(page):
    want = [False, True, True, False, 0.7, True, True, False]
    assert page.page.evaluate(CONFIRMED, LOOKS) == want


class DeadConnection:
    """Reloads a page, whose first connection is dead in one direction: nothing arrives."""

    def __init__(self, page):
        self.page, self.held, self.sockets, self.works = page, [], [], False
        page.page.route_web_socket("**/ws*", self._connect)
        page.page.reload()
        page.until(lambda: page.pts is not None)

    def _connect(self, socket):
        server = socket.connect_to_server()
        socket.on_message(lambda text: server.send(text) if self.works else self.held.append(text))
        self.sockets.append(socket)

    def replace(self):
        """Break the connection once a look was sent; the next one works."""
        self.page.until(lambda: any('"look"' in text for text in self.held))
        self.works = True
        self.sockets[0].close()
        self.page.until(lambda: len(self.sockets) == 2)
        self.page.until(lambda: not self.page.page.is_visible("#veil"))


def test_a_look_sent_as_the_connection_broke_is_sent_again(page):
    connection = DeadConnection(page)
    page.page.fill("#lips-panel .hex", "#102030")
    page.until(lambda: any('"look"' in text for text in connection.held))
    mine = page.look()
    connection.replace()
    page.page.wait_for_timeout(300)
    assert page.look() == mine


def test_a_file_sent_as_the_connection_broke_is_sent_again(page, tmp_path):
    ready_look("sunset").look.save(tmp_path / "evening.json")
    connection = DeadConnection(page)
    page.page.set_input_files("#open-look input", tmp_path / "evening.json")
    connection.replace()
    page.until(lambda: page.page.input_value("#name") == "evening")
    assert page.look() == ready_look("sunset").look


# The events and state of a store when a photo's look comes while ours is on its way.
PHOTO = """async ([look, other]) => {
    const { LookStore } = await import("/static/look.js");
    const store = new LookStore(() => true);
    store.start(look, null); // so far no photo, so there is nothing to return to
    store.edit((copy) => (copy.strength = 0.6));
    let canReturn = null;
    store.addEventListener("change", () => (canReturn = !store.isPhotoLook));
    store.receive(other, { name: "anna.jpg", look: other }, null);
    return [canReturn, store.look.strength, store.name];
}"""


def test_a_photo_during_an_edit_can_be_returned_to(page):
    assert page.page.evaluate(PHOTO, LOOKS) == [True, 0.6, "look"]


# How often H.264 is given up, and what is acknowledged, where a decoder fails with packets of both
# pictures on their way.
BROKEN = """async () => {
    const { Picture } = await import("/static/picture.js");
    window.VideoDecoder = class {
        state = "configured";
        configure() {}
        decode() { throw new DOMException("broken", "EncodingError"); }
        close() { this.state = "closed"; }
    };
    const data = new Uint8Array([0, 0, 1, 0x67, 0x42, 0xc0, 0x28]);
    const shown = [];
    let fails = 0;
    const canvas = document.createElement("canvas");
    const picture = new Picture(canvas, (pts) => shown.push(pts), () => {}, () => (fails += 1));
    for (const pts of [1, 2, 3]) {
        const part = { data, isKey: pts < 3 };
        picture.show({ pts, rotation: 0, isVideo: true, painted: part, before: part });
        await new Promise((resolve) => setTimeout(resolve, 50));
    }
    return [fails, shown];
}"""


def test_a_decoder_that_fails_is_given_up_once(page):
    assert page.page.evaluate(BROKEN) == [1, [1, 2, 3]]
