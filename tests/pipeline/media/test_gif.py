"""FFmpeg calls every GIF transparent; a GIF that is opaque becomes an opaque video."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.media.input_file import open_video
from media import decoded, picture
from PIL import Image

HOLE = (10, 10, 40, 40)


def frames(*, holes_from: int | None, count: int = 4) -> list[Image.Image]:
    """`count` pictures, with a transparent hole from number `holes_from` on."""
    images = []
    for index in range(count):
        rgb = picture(index, 96, 64, "rgb24").to_ndarray(format="rgb24")
        images.append(Image.fromarray(rgb).convert("RGBA"))
        if holes_from is not None and index >= holes_from:
            images[-1].paste((0, 0, 0, 0), HOLE)
    return images


def gif(path: Path, images: list[Image.Image], **options: int) -> Path:
    first, *rest = images
    if rest:
        first.save(path, save_all=True, append_images=rest, duration=100, **options)
    else:
        first.save(path)
    return path


def is_seen_through(path: Path) -> bool:
    return any(np.any(one.to_ndarray(format="bgra")[..., 3] < 255) for one in decoded(path))


@pytest.mark.parametrize(
    ("holes_from", "disposal", "is_opaque"),
    [
        (None, 0, True),
        (None, 1, True),
        (1, 1, True),  # most programs leave out what does not change
        (0, 1, False),
        (0, 2, False),
        (1, 2, False),
    ],
)
@pytest.mark.parametrize("end", [".mp4", ".mov"])
def test_only_a_gif_that_shows_through_has_a_line(tmp_path, holes_from, disposal, is_opaque, end):
    src = gif(tmp_path / "in.gif", frames(holes_from=holes_from), disposal=disposal)
    assert is_seen_through(src) != is_opaque
    with closing(open_video(src)) as source:
        assert (source.has_alpha, source.is_opaque) == (not is_opaque, is_opaque)
    report = process_video(src, tmp_path / f"out{end}")
    assert bool(report.dropped) == (not is_opaque and end == ".mp4")
    assert report.codec == ("prores" if not is_opaque and end == ".mov" else "h264")


@pytest.mark.parametrize("codec_end", [("ffv1", ".mkv"), ("prores", ".mov"), ("vp9", ".webm")])
def test_an_opaque_gif_becomes_an_opaque_video(tmp_path, codec_end):
    codec, end = codec_end
    image = frames(holes_from=None, count=1)[0].convert("RGB")
    src = gif(tmp_path / "in.gif", [image])
    assert src.read_bytes().startswith(b"GIF87a")
    process_video(src, tmp_path / f"out{end}", None, Settings(codec=codec))
    (frame,) = decoded(tmp_path / f"out{end}")
    assert "yuv444p" in frame.format.name
    assert not any(component.is_alpha for component in frame.format.components)


def test_a_gif_cut_short_counts_as_transparent(tmp_path):
    src = gif(tmp_path / "in.gif", frames(holes_from=None))
    src.write_bytes(src.read_bytes()[:-2000])
    with closing(open_video(src)) as source:
        assert source.has_alpha and not source.is_opaque


def test_a_second_gif_behind_the_first_one_counts(tmp_path):
    """FFmpeg decodes the pictures of both."""
    first = gif(tmp_path / "a.gif", frames(holes_from=None))
    second = gif(tmp_path / "b.gif", frames(holes_from=0), disposal=1)
    src = tmp_path / "in.gif"
    src.write_bytes(first.read_bytes() + second.read_bytes())
    with closing(open_video(src)) as source:
        assert not source.is_opaque
