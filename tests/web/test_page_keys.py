"""Keys of the whole page, and the chips that say where the picture is without makeup."""

import re

import pytest
from makeup_video.web.app import PAGE

# Names of keys in `aria-keyshortcuts`, by WAI-ARIA: "+" joins keys, so the key itself is "Plus".
SHORTCUT = re.compile(r"(Control\+|Shift\+)*([A-Z]|[-?]|Plus)")


@pytest.fixture
def page(demo, visit):
    return visit(demo)


def is_pressed(page, button):
    return page.page.get_attribute(f"#{button}", "aria-pressed") == "true"


def test_shortcuts_are_named_as_aria_asks():
    shortcuts = re.findall(r'aria-keyshortcuts="(.+?)"', (PAGE / "index.html").read_text())
    assert len(shortcuts) > 5
    for shortcut in " ".join(shortcuts).split():
        assert SHORTCUT.fullmatch(shortcut), shortcut


def test_the_divider_says_its_place_in_percent(page):
    page.page.keyboard.press("c")
    assert page.page.get_attribute("#divider", "aria-valuetext") == "50% before"


def test_single_keys_are_switched_off_and_stay_so(page):
    keys = page.page.keyboard
    keys.press("?")
    page.page.uncheck("#single-keys")
    page.page.click("#help button")
    before = page.look()
    page.page.fill("#lips-panel .hex", "#102030")
    page.page.click("#picture")
    keys.press("c")
    keys.press("?")
    keys.down("b")
    assert not is_pressed(page, "compare-button")
    assert not page.page.is_visible("#help")
    assert page.page.get_attribute("#held", "hidden") is not None
    keys.up("b")
    keys.press("Control+z")  # not a single-key shortcut, so it still works
    assert page.look() == before
    page.page.reload()
    page.until(lambda: page.pts is not None)
    keys.press("c")
    assert not is_pressed(page, "compare-button")
    page.page.click("#help-button")
    page.page.check("#single-keys")
    page.page.click("#help button")
    keys.press("c")
    assert is_pressed(page, "compare-button")


# Shows the picture again, with or without one without makeup, and waits until it is drawn.
SHOW = """async (hasBefore) => {
    const { Picture } = await import("/static/picture.js");
    const canvas = document.getElementById("picture");
    const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg"));
    const part = { data: new Uint8Array(await blob.arrayBuffer()) };
    await new Promise((shown) => new Picture(canvas, shown, () => {}, () => {}).show(
        { pts: 1, rotation: 0, isVideo: false, painted: part, before: hasBefore ? part : null }));
}"""


def test_before_is_said_only_over_a_picture_without_makeup(page):
    chips = [page.page.locator(one) for one in ("#compare .before", "#held")]
    page.page.keyboard.press("c")
    page.until(lambda: chips[0].is_visible())  # the server has sent the picture without makeup
    page.page.keyboard.down("b")
    assert chips[1].is_visible()
    page.page.evaluate(SHOW, False)
    assert not any(chip.is_visible() for chip in chips)
    page.page.evaluate(SHOW, True)
    assert all(chip.is_visible() for chip in chips)
