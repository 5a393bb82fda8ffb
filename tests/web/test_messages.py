"""Messages of pages are parsed strictly; an invalid message gives an error of one line."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Look, LookError, MakeupVideoError, product
from makeup_video.pipeline.look.kinds import KINDS, PAINTED
from makeup_video.web.app import PAGE
from makeup_video.web.messages import CompareRequest, LookRequest, PictureShown, hello, read_message
from makeup_video.web.session import HEAD, PHOTO_BYTES, PhotoLook, ShownPicture
from shows import BLUE, StandIn


def test_valid_messages_are_understood():
    look = json.dumps({"type": "look", "look": BLUE.to_dict(), "n": 3})
    assert read_message(look) == LookRequest(BLUE.to_dict(), 3, is_counted=True)
    assert read_message(look).look == BLUE
    assert read_message('{"type": "compare", "on": true}') == CompareRequest(True)
    assert read_message('{"type": "shown", "pts_us": 12}') == PictureShown(12)


@pytest.mark.parametrize(
    "text",
    [
        '{"type": "look", "type": "look", "look": {"version": 2, "layers": []}}',
        '{"type": "look", "look": {"version": 2, "layers": [], "layers": []}}',
        '{"type": "compare", "on": false, "on": true}',
    ],
)
def test_a_key_that_is_given_twice_is_refused(text):
    with pytest.raises(LookError, match="is given twice: keep one"):
        read_message(text)


def changed(**values):
    return json.dumps({"type": "look", "look": {**BLUE.to_dict(), **values}})


def layered(**values):
    (layer,) = BLUE.to_dict()["layers"]
    return changed(layers=[{**layer, **values}])


@pytest.mark.parametrize(
    "text",
    [
        "", "{", "null", "[]", "3", '"look"', "\0", "{}", '{"type": null}', '{"type": "hello"}',
        '{"type": ["look"]}', '{"type": "look"}', '{"type": "look", "look": null}',
        '{"type": "shown"}', '{"type": "shown", "pts_us": "1"}', '{"type": "shown", "pts_us": -1}',
        '{"type": "shown", "pts_us": true}', '{"type": "shown", "pts_us": 1e400}',
        '{"type": "shown", "pts_us": 99999999999999999999}', '{"type": "compare", "on": 1}',
        "[" * 60_000, '{"a":' * 10_000, "9" * 60_000, '{"type": "shown", "pts_us": NaN}',
        changed(strength=2), changed(strength=float("nan")), changed(zone="lid"), changed(more=1),
        changed(layers={}), changed(strength=True), changed(layers=20 * BLUE.to_dict()["layers"]),
        changed(version=3), layered(kind="hat"), layered(shape={"slot": "lid"}), layered(product={}),
        layered(strength=float("inf")), layered(shape={"gradient": 2}), layered(shape=[]),
        json.dumps({"type": "look", "look": BLUE.to_dict(), "n": "x"}),
    ],
)  # fmt: skip
def test_invalid_messages_are_refused_in_one_line(text):
    with pytest.raises(MakeupVideoError) as caught:
        read(text)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


def read(text):
    """Parse a message completely; a look is otherwise parsed only when its turn comes."""
    message = read_message(text)
    if isinstance(message, LookRequest):
        message.look  # noqa: B018  # raises the error


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@settings(deadline=None)
@given(st.dictionaries(st.sampled_from(["type", "look", "on", "pts_us", "n"]), JSON | st.sampled_from(["look", "shown", "compare"])))  # fmt: skip
def test_any_message_is_read_or_refused_in_one_line(values):
    try:
        read(json.dumps(values))
    except MakeupVideoError as error:
        assert "\n" not in str(error)


def test_hello_carries_all_that_a_page_needs():
    message = json.loads(hello("live", StandIn()))
    assert message["mode"] == "live" and message["session"] == "stand-in"
    assert message["photo_bytes_limit"] == PHOTO_BYTES
    assert message["finishes"]["gloss"]["lips"]["opacity"] == 0.94
    assert len(message["parameters"]) == 17
    assert message["photo"] is None
    shown = StandIn()
    shown.photo = PhotoLook("anna.jpg", Look(lips=product((180, 0, 46), "gloss")), "lips #B4002E")
    photo = json.loads(hello("live", shown))["photo"]
    assert Look.from_dict(photo["look"]) == shown.photo.look
    assert photo["name"] == "anna.jpg" and photo["words"] == "lips #B4002E"


def test_hello_describes_every_kind_of_the_registry():
    sent = json.loads(hello("live", StandIn()))
    assert [kind["name"] for kind in sent["kinds"]] == list(KINDS)
    for values, kind in zip(sent["kinds"], KINDS.values(), strict=True):
        assert (values["part"], values["title"], values["most"]) == (
            kind.part,
            kind.title,
            kind.most,
        )
        assert [dial["name"] for dial in values["dials"]] == [dial.name for dial in kind.dials]
        assert kind.first_finish in sent["finishes"]
        for name, shape in values["slots"].items():
            assert shape == kind.whole_shape({"slot": name})
        first = values["first"] | sent["finishes"][kind.first_finish][kind.part]
        layer = {"kind": kind.name, "strength": 1, "product": first, "shape": {}}
        assert Look.from_dict({"version": 2, "strength": 1, "layers": [layer]}).of(kind.name)
    orders = {kind["name"]: kind["order"] for kind in sent["kinds"]}
    assert sorted(orders, key=orders.get) == list(PAINTED)


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_a_swatch_is_drawn_in_a_form_that_the_page_knows(kind):
    (sent,) = [
        one for one in json.loads(hello("live", StandIn()))["kinds"] if one["name"] == kind.name
    ]
    assert f"\nfunction {sent['swatch']}(u, v" in (PAGE / "swatch.js").read_text()


def test_a_picture_is_packed_with_before_only_when_compared():
    picture = ShownPicture(2**40, 270, b"painted", b"bare!")
    assert HEAD.size == 20
    assert picture.packed(True) == HEAD.pack(2**40, 270, 0, 7, 5) + b"paintedbare!"
    assert picture.packed(False) == HEAD.pack(2**40, 270, 0, 7, 0) + b"painted"
    assert ShownPicture(1, 0, b"a").packed(True) == HEAD.pack(1, 0, 0, 1, 0) + b"a"
