"""The page on another machine: H.264 over HTTPS, decoded by the browser."""

import numpy as np
import pytest
from browser import DESK, Served, visits
from makeup_video.web.certificate import lan_address

RED = "#B4002E"
SECURE = {**DESK, "ignore_https_errors": True}


@pytest.fixture(scope="module")
def live(chromium, camera_clip, tmp_path_factory):
    """`live` over HTTPS; a browser at 127.0.0.1 is on this machine, and gets JPEG."""
    served = Served(
        *("live", "--camera", str(camera_clip), "--loop", "--color", RED),
        *("--https", "--host", "0.0.0.0"),
        environment={"XDG_DATA_HOME": str(tmp_path_factory.mktemp("data"))},
    )
    yield served
    assert served.stop() == 0, served.lines


@pytest.fixture
def visit(chromium):
    with visits(chromium) as open_page:
        yield lambda url, **context: open_page(url, **{**SECURE, **context})


def codec(page):
    return page.page.get_attribute("#picture", "data-codec")


def is_red(rgb):
    return rgb is not None and rgb[1] < 0.36 * rgb[0] and rgb[2] < 0.6 * rgb[0]


def why_jpeg(page):
    return page.page.evaluate(
        "() => [...document.querySelectorAll('#figures span')]"
        ".find((one) => one.textContent === 'JPEG')?.title ?? ''"
    )


def settled(page, name):
    """Wait until the page shows pictures of this codec."""
    page.until(lambda: codec(page) == name)
    page.wait_for_pictures(10)
    assert codec(page) == name


def test_a_page_on_this_machine_gets_jpeg(live, visit):
    page = visit(live.url)
    settled(page, "jpeg")
    assert page.page.inner_text("#figures") and not why_jpeg(page)


def test_a_page_from_another_address_gets_h264(live, visit):
    address = lan_address()
    if address is None:
        pytest.skip("this machine has no network")
    page = visit(live.url.replace("127.0.0.1", address))
    settled(page, "h264")
    page.until(lambda: is_red(page.lips()))
    assert page.picture().shape == (360, 640, 3)


def test_a_page_without_https_is_told_why_it_gets_jpeg(chromium, camera_clip):
    address = lan_address()
    if address is None:
        pytest.skip("this machine has no network")
    served = Served("live", "--camera", str(camera_clip), "--loop", "--host", "0.0.0.0")
    try:
        with visits(chromium) as open_page:
            page = open_page(served.url.replace("127.0.0.1", address), **DESK)
            settled(page, "jpeg")
            page.until(lambda: "only in pages over HTTPS (--https)" in why_jpeg(page))
    finally:
        assert served.stop() == 0, served.lines


def test_before_and_after_zoom_and_mirror_work_in_h264(live, visit):
    page = visit(f"{live.url}?video=h264")
    settled(page, "h264")
    page.page.keyboard.press("c")
    divider = page.page.locator("#divider")
    divider.press("End")
    page.until(lambda: page.lips() is not None and not is_red(page.lips()))
    divider.press("Home")
    page.until(lambda: is_red(page.lips()))
    page.page.keyboard.press("c")
    page.page.keyboard.down("b")
    page.until(lambda: page.lips() is not None and not is_red(page.lips()))
    page.page.keyboard.up("b")
    page.until(lambda: is_red(page.lips()))
    page.page.keyboard.press("+")
    page.wait_for_pictures(5)
    page.page.keyboard.press("0")
    settled(page, "h264")


# Notes the mean colours of a grid of 4 x 4 cells, by the pts of the picture.
NOTE_COLOURS = """() => {
    const picture = document.getElementById("picture");
    const small = new OffscreenCanvas(4, 4).getContext("2d", { willReadFrequently: true });
    small.imageSmoothingQuality = "high";
    window.seen = {};
    const note = () => {
        small.drawImage(picture, 0, 0, 4, 4);
        window.seen[picture.dataset.pts] = [...small.getImageData(0, 0, 4, 4).data];
        requestAnimationFrame(note);
    };
    note();
}"""


def test_colours_in_h264_are_those_in_jpeg(live, visit):
    pages = [visit(f"{live.url}?video={name}") for name in ("jpeg", "h264")]
    for page, name in zip(pages, ("jpeg", "h264"), strict=True):
        settled(page, name)
        page.page.evaluate(NOTE_COLOURS)

    def both():
        jpeg, h264 = (page.page.evaluate("() => window.seen") for page in pages)
        common = sorted(jpeg.keys() & h264.keys())
        return [(jpeg[pts], h264[pts]) for pts in common] if len(common) > 10 else None

    jpeg, h264 = np.moveaxis(np.array(pages[0].until(both)), 1, 0)
    assert np.abs(jpeg - h264).max() < 5  # each rounds several times
    assert np.abs((jpeg - h264).mean(0)).max() < 3


def test_a_page_returns_to_jpeg_when_its_decoder_fails(live, visit):
    page = visit(f"{live.url}?video=h264")
    settled(page, "h264")
    page.page.evaluate(
        """() => (VideoDecoder.prototype.decode = () => {
            throw new DOMException("broken", "EncodingError");
        })"""
    )
    settled(page, "jpeg")
    page.until(lambda: is_red(page.lips()))
    page.until(lambda: "decoder failed" in why_jpeg(page))


def test_a_page_returns_to_jpeg_when_its_decoder_is_silent(live, visit):
    page = visit(f"{live.url}?video=h264")
    settled(page, "h264")
    page.page.evaluate("() => (VideoDecoder.prototype.decode = () => {})")
    settled(page, "jpeg")


def test_a_browser_without_a_decoder_gets_jpeg(live, visit, chromium):
    page = visit(f"{live.url}?video=h264")
    page.page.add_init_script("delete window.VideoDecoder")
    page.page.reload()
    page.until(lambda: page.pts is not None)
    settled(page, "jpeg")
    page.until(lambda: "this browser cannot decode it" in why_jpeg(page))


def test_a_second_page_joins_a_running_stream(live, visit):
    first = visit(f"{live.url}?video=h264")
    settled(first, "h264")
    second = visit(f"{live.url}?video=h264")
    settled(second, "h264")
    first.wait_for_pictures(10)
