"""What is typed into the fields of numbers and colours."""

import pytest
from browser import PHONE
from makeup_video.pipeline.look.kinds import PARTS


@pytest.fixture
def page(demo, visit):
    return visit(demo)


@pytest.mark.parametrize(
    "typed, shown, painted", [("0.55555", "0.56", 0.56), ("2", "1.00", 1), ("-3", "0.00", 0)]
)
def test_a_number_is_painted_as_it_is_shown(page, typed, shown, painted):
    field = page.page.get_by_label("Opacity, as a number").first
    field.fill(typed)
    field.press("Enter")
    assert field.input_value() == shown
    assert page.look().lips.opacity == painted
    assert field.input_value() == shown


def test_a_number_that_is_deleted_comes_back(page):
    field = page.page.get_by_label("Opacity, as a number").first
    before = field.input_value(), page.look()
    field.fill("")
    field.press("Tab")
    assert (field.input_value(), page.look()) == before


def test_a_text_that_is_no_colour_leaves_the_colour(page):
    before = page.look()
    field = page.page.locator("#lips-panel .hex").first
    field.fill("")
    field.press_sequentially("B4002E")
    assert page.look().lips.hex == "#B4002E"
    field.press("Enter")
    field.fill("")
    field.press_sequentially("10203040")
    field.press("Enter")
    assert "“10203040” is not a colour" in page.page.inner_text("#lips-panel > .error")
    assert field.input_value() == "#B4002E"
    assert page.look().lips.hex == "#B4002E"
    field.fill("")
    field.press_sequentially("10203040")
    field.press("Tab")
    assert page.look().lips.hex == "#B4002E"
    assert before.lips.hex != "#10203040"


def test_a_wrong_text_brings_no_older_colour_back(page):
    field = page.page.locator("#lips-panel .hex").first
    first = field.input_value()
    for colour in ("#102030", first):  # ends with the first text, so no "change" event
        field.press("Control+a")
        field.press_sequentially(colour)
    field.press("Tab")
    page.page.locator("#lips-panel input[type=color]").first.fill("#405060")
    field.fill("")
    field.press_sequentially("none")
    field.press("Enter")
    assert field.input_value() == "#405060"


PASTE = """([selector, text]) => {
    const clipboardData = new DataTransfer();
    clipboardData.items.add(new File(["no photo"], "copied.png", { type: "image/png" }));
    if (text) clipboardData.setData("text/plain", text);
    const event = new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true });
    document.querySelector(selector).dispatchEvent(event);
    return event.defaultPrevented;
}"""


@pytest.mark.parametrize(
    "selector, text, is_photo",
    [("#name", "evening", False), ("#name", "", True), ("#undo", "evening", True)],
)
def test_text_with_a_picture_of_itself_is_pasted_as_text(page, selector, text, is_photo):
    assert page.page.evaluate(PASTE, [selector, text]) == is_photo
    if is_photo:
        page.until(lambda: "copied.png" in page.page.inner_text("#photo-slot .error"))
    assert page.page.get_attribute("#photo-slot", "class") == "slot"


# The visible fields whose letters are smaller than 16 px, which makes iPhones enlarge the page, or
# whose widest text is cut off.
WRONG = """() => [...document.querySelectorAll("input, select")]
    .filter((one) => one.clientWidth > 1 && ["text", "number", "search", "select-one"].includes(one.type))
    .filter((one) => {
        if (one.type === "number") one.value = one.max.length > one.min.length ? one.max : one.min;
        if (one.type === "number" && one.step < 1) one.value = Number(one.value).toFixed(2);
        if (one.className === "hex") one.value = "#DDDDDD";
        return parseFloat(getComputedStyle(one).fontSize) < 16 || one.scrollWidth > one.clientWidth;
    })
    .map((one) => `${one.ariaLabel ?? one.id}: ${one.value}`)"""

# The choice of a camera, as `live` shows it.
CAMERA = """() => {
    const camera = document.getElementById("camera");
    camera.append(document.createElement("select"));
    camera.hidden = false;
}"""


def test_on_a_phone_fields_have_letters_of_full_size(demo, visit):
    page = visit(demo, **PHONE)
    page.page.evaluate(CAMERA)
    for part in PARTS:
        page.page.click(f"#{part}-tab")
        page.open_groups()
        assert page.page.evaluate(WRONG) == []
