"""Shades, kept looks, zoom and the choice of a face, in a real browser."""

import cv2
import numpy as np
import pytest
from browser import PHONE
from makeup_video.pipeline import Look, apply_look, product
from makeup_video.pipeline.look.ready import ready_looks
from people import portrait

TABLE = """brand,product,shade,hex,type
Acme,Velvet,Ruby,#B4002E,lipstick
Acme,Velvet,Plum night,#5A1E40,lipstick
Bee,Shadow,Sand,#C8A888,eyeshadow
"""


@pytest.fixture
def page(demo, visit):
    return visit(demo)


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "shades.csv"
    path.write_text(TABLE)
    return path


def names(page, part="lips"):
    return page.page.locator(f"#{part}-panel .shades.all button").all_inner_texts()


def test_a_catalogue_becomes_swatches_of_each_kind(page, table):
    page.drop(table)
    page.until(lambda: names(page) == ["Acme Velvet Ruby", "Acme Velvet Plum night"])
    page.page.get_by_role("button", name="Acme Velvet Plum night, #5A1E40").click()
    assert page.look().lips.hex == "#5A1E40"
    page.page.fill("#lips-panel [type=search]", "ruby acme")
    assert names(page) == ["Acme Velvet Ruby"]
    page.page.fill("#lips-panel [type=search]", "green")
    assert "No shade has this name" in page.page.inner_text("#lips-panel .catalogue")
    page.page.click("#eyes-tab")
    assert names(page, "eyes") == ["Bee Shadow Sand"]
    page.page.reload()  # the browser keeps the catalogue
    page.until(lambda: len(names(page)) == 2)
    page.page.click("#lips-panel [aria-label='Close the catalogue']")
    assert not page.page.is_visible("#lips-panel .catalogue")


@pytest.mark.parametrize("kind", ["text/csv", "application/vnd.ms-excel"])
def test_a_dragged_catalogue_is_offered_as_shades(page, table, kind):
    assert page.drop(table, kind=kind) == ["Show these shades"]
    page.until(lambda: names(page) == ["Acme Velvet Ruby", "Acme Velvet Plum night"])


def test_a_faulty_catalogue_says_why_and_where(page, table):
    table.write_text(TABLE.replace("#5A1E40", "plum"))
    page.page.set_input_files("#lips-panel .open-shades input", table)
    page.until(lambda: "shades.csv, line 3: hex must be" in page.page.inner_text("#error"))


def test_shades_that_were_used_or_kept_come_back(page):
    own = page.page.locator("#lips-panel .shades:not(.all) button")
    labels = lambda: [one.get_attribute("aria-label") for one in own.all()]
    for colour in ("#102030", "#405060"):
        page.page.fill("#lips-panel .hex", colour)
        page.until(lambda: colour in labels())  # noqa: B023
    assert labels()[:2] == ["#405060", "#102030"]
    page.page.get_by_role("button", name="Keep this shade").first.click()
    page.page.fill("#lips-panel .hex", "#708090")
    page.until(lambda: labels()[:3] == ["#405060", "#708090", "#102030"])
    assert own.first.inner_text().startswith("★")
    page.page.reload()
    page.until(lambda: labels()[:3] == ["#405060", "#708090", "#102030"])
    own.first.click()
    assert page.look().lips.hex == "#405060"
    page.page.get_by_role("button", name="Keep this shade", pressed=True).first.click()
    page.until(lambda: not own.first.inner_text().startswith("★"))


def test_a_wrong_colour_is_said_and_the_old_one_stays(page):
    field = page.page.locator("#lips-panel .hex").first
    before = field.input_value()
    field.fill("B4002")
    field.press("Enter")
    said = page.page.locator("#lips-panel > .error")
    assert said.inner_text() == "“B4002” is not a colour: give six hex digits, such as B4002E."
    field.press("Tab")
    assert field.input_value() == before
    field.fill("B4002E")
    assert said.inner_text() == ""


def test_a_kept_look_is_a_thumbnail_on_the_portrait(page):
    page.page.fill("#lips-panel .hex", "#1020C0")
    page.page.fill("#name", "my blue")
    look = page.look()
    page.page.click("#keep-look")
    buttons = page.page.locator("#ready .thumbs button")
    assert buttons.count() == len(ready_looks()) + 1
    assert buttons.first.inner_text().strip() == "my blue"
    drawn = "() => { const one = document.querySelector('#ready img'); return one.naturalWidth && !one.hidden; }"
    page.until(lambda: page.page.evaluate(drawn))
    buttons.nth(1).click()
    assert page.look() == ready_looks()[0].look
    page.page.reload()
    page.until(lambda: buttons.count() == len(ready_looks()) + 1)
    buttons.first.click()
    assert page.look() == look
    page.page.click("#keep-look")
    assert buttons.count() == len(ready_looks())


def centre(page):
    rgb8 = page.picture()
    (h, w), half = rgb8.shape[:2], 20
    return rgb8[h // 2 - half : h // 2 + half, w // 2 - half : w // 2 + half].astype(int)


def test_a_drag_that_ends_beside_the_picture_ends(page):
    page.page.wait_for_timeout(300)
    page.page.click("#zoom-button")
    page.until(lambda: page.page.get_attribute("#zoom-button", "aria-pressed") == "true")
    box = page.page.locator("#frame").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x - 30, y)
    page.page.mouse.move(1, 1)  # beside the picture
    page.page.mouse.up()
    page.page.mouse.move(x, y)
    page.page.wait_for_timeout(300)
    before = page.picture().astype(int)
    page.page.mouse.move(x + 60, y + 40, steps=5)
    page.page.wait_for_timeout(500)
    assert np.abs(page.picture().astype(int) - before).mean() < 1


def test_zoom_enlarges_the_middle_and_arrows_move_it(page):
    page.page.wait_for_timeout(300)
    whole = page.picture().astype(int)
    page.page.click("#zoom-button")
    page.until(lambda: np.abs(page.picture().astype(int) - whole).mean() > 5)
    h, w = whole.shape[:2]
    part = whole[round(h * 0.3) : round(h * 0.7), round(w * 0.3) : round(w * 0.7)]
    enlarged = cv2.resize(part.astype(np.uint8), (w, h)).astype(int)
    assert np.abs(page.picture().astype(int) - enlarged).mean() < 3
    before = page.picture().astype(int)
    page.page.focus("#frame")
    page.page.keyboard.press("ArrowRight")
    page.until(lambda: np.abs(page.picture().astype(int) - before).mean() > 2)
    page.page.keyboard.press("0")
    page.until(lambda: np.abs(page.picture().astype(int) - whole).mean() < 1)
    page.page.mouse.move(400, 300)
    page.page.mouse.wheel(0, -400)
    page.until(lambda: page.page.get_attribute("#zoom-button", "aria-pressed") == "true")


def test_of_several_faces_one_is_clicked(page, tmp_path):
    painted = apply_look(portrait(), Look(lips=product((20, 0, 200), "satin")))
    both = np.hstack([portrait(), painted])
    cv2.imwrite(str(tmp_path / "both.png"), both[..., ::-1])
    page.drop(tmp_path / "both.png", ".target[data-kind=photo]")
    page.until(lambda: page.page.is_visible("#faces"))
    assert page.page.inner_text("#faces h2") == "both.png shows 2 faces: choose one"
    faces = page.page.locator("#faces .picture button")
    assert faces.all_inner_texts() == ["0", "1"]  # as the command numbers them
    boxes = [one.bounding_box() for one in faces.all()]
    assert all(min(box["width"], box["height"]) > 40 for box in boxes)
    right = max(range(2), key=lambda at: boxes[at]["x"])
    faces.nth(right).click()
    page.until(lambda: "both.png" in page.page.inner_text("#photo-slot b"))
    lips = page.look().lips
    assert lips.blue > 1.5 * lips.red


def test_no_face_chosen_leaves_the_look(page, tmp_path):
    before = page.look()
    cv2.imwrite(str(tmp_path / "both.png"), np.hstack([portrait(), portrait()])[..., ::-1])
    page.drop(tmp_path / "both.png", ".target[data-kind=photo]")
    page.until(lambda: page.page.is_visible("#faces"))
    page.page.keyboard.press("Escape")
    page.until(lambda: "No face was chosen" in page.page.inner_text("#photo-slot .error"))
    assert page.look() == before


def test_before_and_after_are_saved_side_by_side(page):
    page.until(lambda: page.page.is_visible("#photo-slot"))
    with page.page.expect_download() as download:
        page.page.click("#save-both")
    stored = cv2.imread(str(download.value.path()))
    left, right = np.hsplit(stored.astype(int), 2)
    changed = np.abs(left - right).max(-1) > 20
    assert 0.001 < changed.mean() < 0.1  # the lips alone


@pytest.mark.parametrize("size", [{}, PHONE])
def test_the_page_has_one_heading_and_a_name_for_each_control(demo, visit, size):
    page = visit(demo, **size)
    page.open_groups()
    assert page.page.locator("h1").all_inner_texts() == ["makeup-video"]
    nameless = page.page.evaluate(
        """() => [...document.querySelectorAll("button, input, [role=slider]")]
            .filter((one) => one.offsetParent && !(one.ariaLabel || one.labels?.length || one.innerText.trim()
                || one.title || one.querySelector("span")))
            .map((one) => one.outerHTML.slice(0, 90))"""
    )
    assert nameless == []
