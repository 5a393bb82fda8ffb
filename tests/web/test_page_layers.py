"""The controls of kinds, layers, shapes and ready looks, in a real browser."""

import json

import numpy as np
import pytest
from browser import PHONE
from looks import layer_of
from makeup_video.pipeline.look.kinds import KINDS, PARTS
from makeup_video.pipeline.look.kinds.density_map import HW, to_text
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.ready import ready_looks
from people import SAMPLES

SEVERAL = next(kind for kind in KINDS.values() if kind.most > 1)


@pytest.fixture
def page(demo, visit):
    return visit(demo)


def panel(page, part):
    page.page.click(f"#{part}-tab")
    return page.page.locator(f"#{part}-panel")


def number(panel, title):
    return panel.get_by_label(f"{title}, as a number", exact=True)


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_each_kind_has_a_tab_and_all_its_dials(page, kind):
    controls = panel(page, kind.part)
    assert kind.title in page.page.inner_text(f"#{kind.part}-tab")
    switch = controls.get_by_role("switch", name=kind.product)
    switch.set_checked(False)
    assert not page.look().of(kind.name) and "bare" in page.page.inner_text(f"#{kind.part}-tab")
    page.open_groups()
    dials = [dial for dial in kind.dials if not dial.is_map]
    for dial in dials:
        if dial.choices:
            group = controls.get_by_role("radiogroup", name=dial.meaning)
            offered = group.locator("label").all_inner_texts()
            assert offered == [choice.replace("_", " ") for choice in dial.choices]
        elif dial.is_colour:
            controls.get_by_label(f"{dial.title}, as hex digits").fill("#102030")
        else:
            assert (
                controls.get_by_label(dial.title, exact=True).get_attribute("max")
                == f"{dial.high:g}"
            )
            number(controls, dial.title).fill(f"{dial.high:g}")
    assert switch.is_checked()  # any change puts the makeup on
    (layer,) = page.look().of(kind.name)
    assert layer.shape == {
        dial.name: "#102030" if dial.is_colour else dial.high for dial in dials if not dial.choices
    }
    page.page.click(f"#{kind.part}-panel .finishes button:has-text('gloss')")
    assert page.look().of(kind.name)[0].product.opacity == kind.finish("gloss")["opacity"]


def test_layers_are_added_changed_and_removed_one_by_one(page):
    controls = panel(page, SEVERAL.part)
    controls.get_by_role("switch").set_checked(True)
    for count in range(2, SEVERAL.most + 1):
        controls.get_by_role("button", name="Add a layer").click()
        assert len(page.look().of(SEVERAL.name)) == count
    assert not controls.get_by_role("button", name="Add a layer").is_visible()
    assert f"{SEVERAL.most} layers" in page.page.inner_text(f"#{SEVERAL.part}-tab")
    places = [layer.whole_shape["slot"] for layer in page.look().of(SEVERAL.name)]
    assert len(set(places)) == SEVERAL.most
    before = page.look().of(SEVERAL.name)
    controls.get_by_role("button", name="Layer 2:").click()
    controls.locator(".hex").first.fill("#102030")
    number(controls, "Strength").fill("0.25")
    after = page.look().of(SEVERAL.name)
    assert (after[1].product.hex, after[1].strength) == ("#102030", 0.25)
    assert (after[0], *after[2:]) == (before[0], *before[2:])
    controls.get_by_role("button", name="Remove layer").click()
    assert page.look().of(SEVERAL.name) == (before[0], *before[2:])
    page.page.click("#undo")
    assert page.look().of(SEVERAL.name) == after
    while controls.get_by_role("button", name="Remove layer").is_visible():
        controls.get_by_role("button", name="Remove layer").click()
    assert len(page.look().of(SEVERAL.name)) == 1
    controls.get_by_role("switch").set_checked(False)
    assert not page.look().of(SEVERAL.name)
    page.page.click("#undo")
    assert len(page.look().of(SEVERAL.name)) == 1


def test_a_slot_gives_the_numbers_and_a_slider_changes_one(page):
    controls = panel(page, "eyes")
    controls.locator("summary", has_text="Shape").click()
    for slot, numbers in PARTS["eyes"].slots.items():
        controls.locator(f".choices input[value={slot}]").click(force=True)
        assert page.look().of("eyeshadow")[0].shape == {"slot": slot}
        for dial in PARTS["eyes"].dials:
            if not (dial.is_map or dial.choices):
                assert float(number(controls, dial.title).input_value()) == numbers[dial.name]
    number(controls, "Outer").fill("1.5")
    assert page.look().of("eyeshadow")[0].shape == {"slot": slot, "outer": 1.5}
    controls.locator(f".choices input[value={slot}]").click(force=True)  # back to its own numbers
    assert page.look().of("eyeshadow")[0].shape == {"slot": slot}


def test_an_eye_of_its_own_stays_with_the_layer(page):
    controls = panel(page, "eyes")
    controls.get_by_role("switch").set_checked(True)
    controls.locator(".choices input[value=left]").click(force=True)
    assert page.look().of("eyeshadow")[0].shape == {"eye": "left"}
    assert "lid, left eye" in controls.get_by_role("group", name="Layers").inner_text()
    controls.locator(".choices input[value=outer]").click(force=True)
    assert page.look().of("eyeshadow")[0].shape == {"eye": "left", "slot": "outer"}
    for _ in range(SEVERAL.most - 1):
        controls.get_by_role("button", name="Add a layer").click()
    shapes = [layer.shape for layer in page.look().of("eyeshadow")]
    assert {shape["eye"] for shape in shapes} == {"left"}
    assert len({shape["slot"] for shape in shapes}) == SEVERAL.most
    controls.get_by_role("button", name="Add a layer").wait_for(state="hidden")
    controls.locator(".choices input[value=right]").click(force=True)  # the right eye has room
    controls.get_by_role("button", name="Add a layer").click()
    assert [layer.shape["eye"] for layer in page.look().of("eyeshadow")].count("right") == 2


def test_a_layer_as_in_a_photo_can_get_a_plain_shape(page, tmp_path):
    shape = {"slot": "outer", "map": to_text(np.full(HW, 0.5))}
    Look([layer_of("eyeshadow", "#141EA0", shape=shape)]).save(tmp_path / "read.json")
    page.page.set_input_files("#open-look input", tmp_path / "read.json")
    page.until(lambda: page.page.input_value("#eyes-panel .hex") == "#141EA0")
    assert page.look().of("eyeshadow")[0].shape == shape
    controls = panel(page, "eyes")
    controls.locator("summary", has_text="Shape").click()
    assert not number(controls, "Outer").is_visible()
    controls.get_by_role("button", name="Use a plain shape").click()
    assert controls.locator(":focus").get_attribute("type") == "range"
    assert page.look().of("eyeshadow")[0].shape == {"slot": "outer"}
    assert number(controls, "Outer").is_visible()
    assert not controls.get_by_text("Shaped as in the photo").is_visible()
    page.page.click("#undo")
    assert page.look().of("eyeshadow")[0].shape == shape
    assert controls.get_by_text("Shaped as in the photo").is_visible()


def test_a_ready_look_replaces_the_look_as_one_step(page):
    before = page.look()
    shown = "() => [...document.querySelectorAll('#ready img')].filter((one) => one.naturalWidth && !one.hidden).length"
    page.until(lambda: page.page.evaluate(shown) == len(ready_looks()))
    buttons = page.page.locator("#ready .thumbs button")
    for at, one in enumerate(ready_looks()):
        buttons.nth(at).click()
        assert page.look() == one.look
        assert buttons.nth(at).get_attribute("aria-pressed") == "true"
        page.page.click("#undo")
        assert page.look() == before
    assert buttons.nth(0).get_attribute("aria-pressed") == "false"


def test_another_portrait_has_other_thumbnails(page, tmp_path):
    first = "() => document.querySelector('#ready img').src"
    page.until(lambda: page.page.evaluate(first))
    before = page.page.evaluate(first)
    page.drop(SAMPLES / "portrait.jpg", "#portrait-slot")
    page.until(lambda: page.page.evaluate(first) != before)


def test_a_file_of_version_1_opens_and_saves_as_version_2(page, tmp_path):
    product = {
        "red": 20, "green": 30, "blue": 160, "opacity": 0.8, "gloss": 0.5, "gloss_roughness": 0.5,
        "reflection": 0.1,
    }  # fmt: skip
    old = {"version": 1, "lips": None, "eyes": product, "zone": "outer", "intensity": 0.5}
    (tmp_path / "old.json").write_text(json.dumps(old))
    page.page.set_input_files("#open-look input", tmp_path / "old.json")
    page.until(lambda: page.page.input_value("#eyes-panel .hex") == "#141EA0")
    (layer,) = page.look().layers
    assert (layer.kind, layer.shape, layer.strength) == ("eyeshadow", {"slot": "outer"}, 0.5)
    assert panel(page, "eyes").locator(".choices input[value=outer]").is_checked()
    page.page.click("#undo")
    assert page.look().lips is not None


def test_arrow_keys_move_between_tabs_looks_and_layers(page):
    keys = page.page.keyboard
    page.page.focus(f"#{next(iter(PARTS))}-tab")
    for part in list(PARTS)[1:]:
        keys.press("ArrowRight")
        assert page.page.is_visible(f"#{part}-panel")
    keys.press("ArrowRight")
    assert page.page.is_visible(f"#{next(iter(PARTS))}-panel")
    page.page.focus("#ready .thumbs button")
    keys.press("End")
    keys.press("Enter")
    assert page.look() == ready_looks()[-1].look


def test_all_tabs_fit_on_a_small_phone(demo, visit):
    page = visit(demo, **PHONE)
    boxes = [page.page.locator(f"#{part}-tab").bounding_box() for part in PARTS]
    assert len({box["y"] for box in boxes}) == 1
    assert boxes[-1]["x"] + boxes[-1]["width"] <= 360
    cut = """(tab) => {
        const title = tab.querySelector("b"), text = document.createRange();
        text.selectNodeContents(title);
        return text.getBoundingClientRect().width > title.getBoundingClientRect().width;
    }"""
    assert not any(page.page.locator(f"#{part}-tab").evaluate(cut) for part in PARTS)
