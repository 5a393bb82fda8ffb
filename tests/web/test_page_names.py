"""Names of looks, and files that a page cannot use."""

import base64
import json

import pytest
from makeup_video.pipeline.look.ready import ready_looks
from people import SAMPLES

LOOK = ready_looks()[0].look.to_dict()


@pytest.fixture
def page(demo, visit):
    return visit(demo)


def name(page):
    return page.page.input_value("#name")


@pytest.fixture
def give(page, tmp_path):
    """Drop a look file of this name with this text, or of this look."""

    def drop(file, look):
        path = tmp_path / file
        path.write_text(look if isinstance(look, str) else json.dumps(look))
        page.drop(path)

    return drop


def test_a_refused_file_is_named_and_the_look_keeps_its_name(page, give):
    page.page.fill("#name", "mine")
    before = page.look()
    give("typo.json", {**LOOK, "strenght": 1})
    page.until(lambda: page.page.inner_text("#error").startswith("typo.json: "))
    assert "strenght" in page.page.inner_text("#error")
    assert (name(page), page.look()) == ("mine", before)
    page.page.fill("#lips-panel .hex", "#102030")
    assert name(page) == "mine"


def test_the_name_is_undone_with_the_look_that_it_came_with(page, give):
    page.page.fill("#name", "mine")
    give("berry.v2.json", LOOK)
    page.until(lambda: name(page) == "berry.v2")
    page.page.click("#undo")
    assert name(page) == "mine"
    page.page.click("#redo")
    assert name(page) == "berry.v2"
    ready = page.page.locator("#ready .thumbs button").nth(1)
    ready.click()
    assert name(page) == ready_looks()[1].name
    page.page.click("#undo")
    assert name(page) == "berry.v2"


def test_a_name_that_is_typed_survives_undoing_an_edit(page):
    page.page.fill("#lips-panel .hex", "#102030")
    page.page.fill("#name", "typed")
    page.page.click("#undo")
    assert name(page) == "typed"
    page.page.click("#redo")
    assert name(page) == "typed"
    assert page.page.input_value("#lips-panel .hex") == "#102030"


def test_a_file_of_the_look_that_is_worn_renames_it(page, give):
    give("first.json", LOOK)
    page.until(lambda: name(page) == "first")
    give("second.json", LOOK)
    page.until(lambda: name(page) == "second")
    page.page.click("#undo")
    assert name(page) == "look"  # one step back, to before the first file


def test_the_look_of_a_photo_has_its_name_until_it_is_undone(page):
    page.page.fill("#name", "mine")
    before = page.look()
    page.drop(SAMPLES / "look.jpg", name="evening.jpg")
    page.until(lambda: name(page) == "evening")
    page.page.click("#undo")
    assert (name(page), page.look()) == ("mine", before)


def test_a_look_file_that_is_too_large_is_refused_by_name(page, give):
    give("large.json", json.dumps(LOOK) + 70_000 * " ")
    page.until(lambda: "large.json has" in page.page.inner_text("#error"))
    assert "64 kB at most: choose" in page.page.inner_text("#error")
    page.page.wait_for_timeout(300)
    assert not page.page.is_visible("#veil")


GONE = """() => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(document.getElementById("probe").files[0]);
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true }));
}"""


@pytest.mark.parametrize("file", ["gone.jpg", "gone.json", "gone.csv"])
def test_a_file_that_is_gone_cannot_be_read(page, tmp_path, file):
    """Nor can a folder, which a browser hands over like a file."""
    (tmp_path / file).write_bytes(b"[]")
    page.page.evaluate(
        "() => document.body.insertAdjacentHTML('beforeend', '<input type=file id=probe>')"
    )
    page.page.set_input_files("#probe", tmp_path / file)
    (tmp_path / file).unlink()
    page.page.evaluate(GONE)
    place = "#photo-slot .error" if file.endswith(".jpg") else "#error"
    page.until(lambda: f"{file} cannot be read" in page.page.inner_text(place))


def test_a_thumbnail_cannot_be_dropped_as_a_new_photo(page):
    images = page.page.locator("#photos img")
    assert images.count() == 2
    assert [one.evaluate("(image) => image.draggable") for one in images.all()] == [False, False]


SEVERAL = """(files) => {
    const dataTransfer = new DataTransfer();
    for (const [name, text] of files) dataTransfer.items.add(new File([atob(text)], name));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true }));
}"""


def test_of_several_dropped_files_one_is_used(page):
    text = base64.b64encode(json.dumps(LOOK).encode()).decode()
    page.page.evaluate(SEVERAL, [["one.json", text], ["two.json", text]])
    page.until(lambda: name(page) == "one")
    page.until(lambda: page.page.is_visible("#notice"))
    assert "only one.json is used" in page.page.inner_text("#notice")
