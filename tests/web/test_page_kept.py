"""What the browser stores for a visitor, in several tabs and whatever the store holds: looks and
shades."""

import json

import pytest
from makeup_video.pipeline.look.ready import ready_looks

READY = len(ready_looks())
LOOK = ready_looks()[0].look.to_dict()


@pytest.fixture
def page(demo, visit):
    return visit(demo)


def reload(page):
    page.page.reload()
    page.until(lambda: page.pts is not None)


def store(page, key, value):
    page.page.evaluate("([key, text]) => localStorage.setItem(key, text)", [key, json.dumps(value)])


def stored(page, key):
    return json.loads(page.page.evaluate("(key) => localStorage.getItem(key)", key))


def names(tab):
    return [name.strip() for name in tab.locator("#ready .thumbs button").all_inner_texts()]


def wear(tab, colour, name):
    tab.fill("#lips-panel .hex", colour)
    tab.fill("#name", name)


def second_tab(page):
    tab = page.context.new_page()
    tab.goto(page.page.url)
    page.until(lambda: len(names(tab)) >= READY)
    return tab


BLOCKED = """for (const place of ["localStorage", "sessionStorage"])
    Object.defineProperty(window, place, {
        get() { throw new DOMException("blocked", "SecurityError"); },
    });"""


def test_a_browser_that_keeps_nothing_keeps_it_for_the_visit(page):
    page.page.add_init_script(BLOCKED)
    reload(page)
    page.until(lambda: len(names(page.page)) == READY)
    for count, colour in enumerate(("#102030", "#405060"), 1):
        wear(page.page, colour, colour)
        page.page.click("#keep-look")
        assert len(names(page.page)) == READY + count


WRONG = {
    "kept shades": [{"lips": 5}, {"lips": [None, {"hex": 7, "title": "x"}]}, 7, [1]],
    "recent shades": [{"lips": "x"}, {"lips": [None, "red"]}, "x", None],
    "recent looks": [7, {}, [7], [{"name": 7, "look": LOOK}]],
    "kept looks": [{}, "abc", [None], [{"name": "x", "look": {}}]],
    "catalogue": [
        {"name": "x", "shades": [{"title": "a", "hex": "#112233"}]},
        {"name": "x"},
        [],
        {"name": "x", "shades": [{"title": "a", "hex": "red", "parts": ["lips"]}]},
    ],
}


@pytest.mark.parametrize("at", range(4))
def test_values_of_an_unexpected_kind_are_passed_over(page, at):
    for key, values in WRONG.items():
        store(page, key, values[at])
    reload(page)
    page.until(lambda: len(names(page.page)) == READY)
    wear(page.page, "#102030", "blue")
    page.page.click("#keep-look")
    assert names(page.page)[0] == "blue"
    page.page.locator("#lips-panel .keep-shade").click()
    own = page.page.locator("#lips-panel .shades:not(.all) button")
    assert [one.get_attribute("aria-label") for one in own.all()] == ["#102030"]
    assert not page.page.is_visible("#lips-panel .catalogue")


def test_beside_a_wrong_entry_the_others_stay(page):
    store(page, "kept looks", [None, {"name": "mine", "look": LOOK}, {"name": "x", "look": {}}])
    store(page, "kept shades", {"lips": [3, {"hex": "#112233", "title": "Night"}], "eyes": 1})
    reload(page)
    page.until(lambda: len(names(page.page)) == READY + 1)
    assert names(page.page)[0] == "mine"
    assert page.page.get_by_role("button", name="Night, #112233").is_visible()


def test_two_tabs_keep_looks_and_shades_in_one_list(page):
    tab = second_tab(page)
    for here, colour in ((page.page, "#102030"), (tab, "#405060")):
        wear(here, colour, f"look {colour}")
        here.click("#keep-look")
        here.locator("#lips-panel .keep-shade").click()
    page.until(lambda: names(page.page)[:2] == ["look #405060", "look #102030"])
    assert names(tab) == names(page.page)
    own = page.page.locator("#lips-panel .shades:not(.all) button")
    kept = lambda: [one.get_attribute("aria-label") for one in own.all()][:2]
    page.until(lambda: kept() == ["#405060", "#102030"])


def test_more_looks_than_there_may_be_are_refused(page):
    kept = [{"name": f"look {at}", "look": {**LOOK, "strength": at / 100}} for at in range(24)]
    store(page, "kept looks", kept)
    reload(page)
    page.until(lambda: len(names(page.page)) == READY + 24)
    wear(page.page, "#102030", "one more")
    page.page.click("#keep-look")
    assert "24 looks are kept" in page.page.inner_text("#error")
    assert stored(page, "kept looks") == kept
    page.page.locator("#ready .thumbs button").nth(3).click()
    page.page.click("#keep-look")
    assert stored(page, "kept looks") == kept[:3] + kept[4:]
    assert page.page.inner_text("#error") == ""


def test_a_kept_look_under_another_name_is_renamed(page):
    wear(page.page, "#102030", "blue")
    button = lambda pressed: page.page.get_by_role(
        "button", name="Keep look", exact=True, pressed=pressed
    )
    button(False).click()
    page.page.fill("#name", "night")
    button(False).click()
    assert names(page.page)[0] == "night" and len(names(page.page)) == READY + 1
    button(True).click()
    assert len(names(page.page)) == READY


def test_a_ready_look_that_is_kept_stands_in_front_only(page):
    ready = names(page.page)
    page.page.locator("#ready .thumbs button").nth(2).click()
    page.page.click("#keep-look")
    kept_first = [ready[2], *ready[:2], *ready[3:]]
    assert names(page.page) == kept_first
    reload(page)
    page.until(lambda: names(page.page) == kept_first)
    page.page.locator("#ready .thumbs button").first.click()
    page.page.click("#keep-look")
    assert names(page.page) == ready


COUNT_URLS = """() => {
    const [make, free] = [URL.createObjectURL, URL.revokeObjectURL];
    window.urls = new Set();
    URL.createObjectURL = (blob) => {
        const url = make.call(URL, blob);
        window.urls.add(url);
        return url;
    };
    URL.revokeObjectURL = (url) => {
        window.urls.delete(url);
        free.call(URL, url);
    };
}"""


def test_the_picture_of_a_look_that_leaves_is_freed(page):
    page.until(lambda: page.page.locator("#ready img:not([hidden])").count() == READY)
    page.page.evaluate(COUNT_URLS)
    wear(page.page, "#102030", "blue")
    page.page.click("#keep-look")
    page.until(lambda: page.page.evaluate("() => window.urls.size") == 1)
    page.page.click("#keep-look")
    assert page.page.evaluate("() => window.urls.size") == 0
