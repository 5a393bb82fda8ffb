"""What is typed into the fields of numbers and colours."""

import pytest


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
    assert "“10203040” is no colour" in page.page.inner_text("#lips-panel > .error")
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
    for colour in ("#102030", first):  # to the same text as before, so that nothing is "changed"
        field.press("Control+a")
        field.press_sequentially(colour)
    field.press("Tab")
    page.page.locator("#lips-panel input[type=color]").first.fill("#405060")
    field.fill("")
    field.press_sequentially("none")
    field.press("Enter")
    assert field.input_value() == "#405060"
