"""Where the focus is after a control has gone, and what is seen in full screen."""

import json

import cv2
import numpy as np
import pytest
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.ready import ready_looks
from people import SAMPLES, portrait

SEVERAL = next(kind for kind in KINDS.values() if kind.most > 1)
LOOK = ready_looks()[0].look.to_dict()


@pytest.fixture
def page(demo, visit):
    return visit(demo)


def is_focused(page, selector):
    return page.page.evaluate("(selector) => document.activeElement.matches(selector)", selector)


def press(page, selector, key="Enter"):
    page.page.focus(selector)
    page.page.keyboard.press(key)


def test_the_focus_stays_in_the_row_when_layers_are_added(page):
    page.page.click(f"#{SEVERAL.part}-tab")
    page.page.set_checked(f"#{SEVERAL.part}-panel [role=switch]", True)
    page.page.focus(f"#{SEVERAL.part}-panel .add")
    for _ in range(SEVERAL.most - 2):
        page.page.keyboard.press("Enter")
        assert is_focused(page, f"#{SEVERAL.part}-panel .add")
    page.page.keyboard.press("Enter")  # adds the last layer that is allowed
    assert is_focused(page, f"#{SEVERAL.part}-panel .swatches button[aria-pressed=true]")


def test_the_focus_stays_on_undo_redo_and_back_to_photo(page, tmp_path):
    page.drop(SAMPLES / "look.jpg")
    page.until(lambda: page.page.is_visible("#look-words"))
    page.page.fill("#lips-panel .hex", "#102030")
    for button in ("undo", "redo", "reset"):
        press(page, f"#{button}")
        assert is_focused(page, f"#{button}")
    assert page.page.get_attribute("#reset", "aria-disabled") == "true"
    before = page.look()
    press(page, "#reset")  # does nothing
    assert page.look() == before


def test_the_focus_goes_from_a_closed_catalogue_to_its_opener(page, tmp_path):
    (tmp_path / "shades.csv").write_text(
        "brand,product,shade,hex,type\nAcme,Velvet,Ruby,#B4002E,lipstick\n"
    )
    page.drop(tmp_path / "shades.csv")
    close = "#lips-panel [aria-label='Close the catalogue']"
    page.until(lambda: page.page.is_visible(close))
    press(page, close)
    assert not page.page.is_visible(close)
    assert is_focused(page, "#lips-panel .open-shades input")


def test_the_focus_goes_from_the_divider_to_its_button(page):
    page.page.keyboard.press("c")
    assert is_focused(page, "#divider")
    page.page.keyboard.press("c")
    assert is_focused(page, "#compare-button")


def test_the_focus_stays_in_the_row_of_looks_beside_a_new_one(page):
    looks = page.page.locator("#ready .thumbs button")
    page.until(lambda: looks.count() == len(ready_looks()))
    looks.nth(2).focus()
    page.drop(SAMPLES / "look.jpg")
    page.until(lambda: looks.count() == len(ready_looks()) + 1)
    focused = page.page.evaluate("() => document.activeElement.textContent.trim()")
    assert focused == ready_looks()[2].name.replace("-", " ")


def test_the_focus_stays_on_a_photo_while_the_page_reconnects(page):
    sockets = []

    def connect(socket):
        socket.connect_to_server()
        sockets.append(socket)

    page.page.route_web_socket("**/ws*", connect)
    page.page.reload()
    page.until(lambda: page.pts is not None)
    for slot in ("photo", "portrait"):
        page.page.focus(f"#{slot}-slot input")
        count = len(sockets)
        sockets[-1].close()
        page.until(lambda: page.page.is_visible("#veil") or len(sockets) > count)  # noqa: B023
        page.until(lambda: not page.page.is_visible("#veil") and len(sockets) > count)  # noqa: B023
        assert is_focused(page, f"#{slot}-slot input")


def test_a_look_without_a_picture_is_called_by_its_name_alone(page):
    page.page.route("**/look-thumbnail?*", lambda route: route.fulfill(status=404))
    page.page.reload()
    looks = page.page.locator("#ready .thumbs button")
    page.until(lambda: looks.count() == len(ready_looks()))
    name = ready_looks()[0].name.replace("-", " ")
    assert page.page.get_by_role("button", name=name, exact=True).count() == 1
    assert page.page.get_by_label("Makeup of: choose a photo").count() == 1


def test_a_newer_photo_closes_the_choice_of_a_face(page, tmp_path):
    cv2.imwrite(str(tmp_path / "both.png"), np.hstack([portrait(), portrait()])[..., ::-1])
    page.drop(tmp_path / "both.png", ".target[data-kind=photo]")
    page.until(lambda: page.page.is_visible("#faces"))
    page.drop(SAMPLES / "look.jpg", ".target[data-kind=photo]")
    page.until(lambda: not page.page.is_visible("#faces"))
    page.until(lambda: "look.jpg" in page.page.inner_text("#photo-slot b"))
    assert page.page.inner_text("#photo-slot .error") == ""


def test_an_error_is_seen_in_full_screen(page, tmp_path):
    page.page.keyboard.press("f")
    page.until(lambda: page.page.evaluate("() => document.fullscreenElement !== null"))
    (tmp_path / "typo.json").write_text(json.dumps({**LOOK, "strenght": 1}))
    (tmp_path / "bad.jpg").write_text("no photo")
    for file in ("typo.json", "bad.jpg"):
        page.drop(tmp_path / file)
        page.until(lambda: file in page.page.inner_text("#notice"))  # noqa: B023
        assert page.page.is_visible("#notice")
    page.page.click("#notice button")
    assert not page.page.is_visible("#notice")


def test_a_browser_without_full_screen_ignores_its_key(page):
    page.page.add_init_script("delete Element.prototype.requestFullscreen")
    page.page.reload()
    page.until(lambda: page.pts is not None)
    page.page.keyboard.press("f")
    page.page.keyboard.press("?")
    assert page.page.is_visible("#help")  # `visit` fails at the test's end if the page had an error
