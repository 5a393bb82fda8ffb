"""The meaning of colour tags, and the defaults for missing tags."""

import pytest
from makeup_video.kernels.colour import Coding
from makeup_video.pipeline import UsageError
from makeup_video.pipeline.frames.colour_tags import ColourTags, resolve
from makeup_video.pipeline.frames.frame import coding_of
from people import frame_of, portrait


@pytest.mark.parametrize(
    ("tags", "size_wh", "want"),
    [
        (ColourTags(), (1920, 1080), Coding(1, False, 13, 1)),
        (ColourTags(), (1280, 536), Coding(1, False, 13, 1)),
        (ColourTags(), (720, 576), Coding(6, False, 13, 1)),
        (ColourTags(), (608, 1080), Coding(1, False, 13, 1)),  # a portrait video
        (ColourTags(matrix=5, range=2), (1920, 1080), Coding(5, True, 13, 1)),
        (ColourTags(1, 1, 1, 1), (320, 240), Coding(1, False, 13, 1)),
        (ColourTags(6, 1, 6, 6), (720, 480), Coding(6, False, 13, 6)),
        (ColourTags(9, 1, 14, 9), (3840, 2160), Coding(9, False, 13, 9)),
        (ColourTags(10, 1, 14, 9), (3840, 2160), Coding(9, False, 13, 9)),
        (ColourTags(9, 1, 16, 2), (3840, 2160), Coding(9, False, 16, 9)),
        (ColourTags(2, 0, 18, 2), (640, 360), Coding(9, False, 18, 9)),
        (ColourTags(2, 0, 2, 9), (640, 360), Coding(9, False, 13, 9)),
        (ColourTags(1, 1, 13, 12), (1080, 1920), Coding(1, False, 13, 12)),
    ],
)
def test_tags_resolve_as_players_resolve_them(tags, size_wh, want):
    assert resolve(tags, *size_wh, 8) == want


@pytest.mark.parametrize("matrix", [0, 8, 14])
def test_an_unknown_matrix_is_refused_by_number(matrix):
    with pytest.raises(UsageError, match=f"matrix {matrix}") as caught:
        resolve(ColourTags(matrix=matrix), 1920, 1080, 8)
    assert "\n" not in str(caught.value)


def test_a_frame_has_the_coding_of_its_tags_and_depth():
    frame = frame_of(portrait(), pix_fmt="yuv420p10le", matrix=9, full_range=True)
    coding = coding_of(frame)
    assert (coding.matrix, coding.full_range, coding.bit_depth) == (9, True, 10)
