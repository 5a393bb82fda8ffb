"""Boxes of mp4 files are walked however they count their sizes, and whatever is damaged."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.media.mp4_boxes import boxes_at, boxes_in, lacks_index, whole_file
from mp4_files import box

LONG = (1).to_bytes(4) + b"wide" + (20).to_bytes(8) + b"1234"
OPEN = bytes(4) + b"mdat" + b"samples"


@pytest.fixture
def walk(tmp_path):
    def walked(data):
        path = tmp_path / "boxes"
        path.write_bytes(data)
        with path.open("rb") as file:
            return [
                (one.name, data[one.begin : one.end]) for one in boxes_in(file, whole_file(path))
            ]

    return walked


def test_sizes_of_four_and_eight_bytes_and_none(walk):
    assert walk(box(b"ftyp", b"isom") + LONG + OPEN) == [
        (b"ftyp", b"isom"), (b"wide", b"1234"), (b"mdat", b"samples"),
    ]  # fmt: skip


def test_damaged_sizes_end_the_walk(walk):
    assert walk(box(b"free", b"") + (7).to_bytes(4) + b"mdat....") == [(b"free", b"")]
    assert walk((99).to_bytes(4) + b"mdat12") == [(b"mdat", b"12")]


def test_boxes_are_found_by_their_path(tmp_path):
    tracks = box(b"trak", box(b"tkhd", b"a")) + box(b"trak", box(b"tkhd", b"b"))
    path = tmp_path / "boxes"
    path.write_bytes(data := box(b"moov", tracks) + box(b"trak", box(b"tkhd", b"c")))
    with path.open("rb") as file:
        found = list(boxes_at(file, whole_file(path), b"moov", b"trak", b"tkhd"))
    assert [data[one.begin : one.end] for one in found] == [b"a", b"b"]


@given(st.binary(max_size=200))
def test_no_file_stops_the_walk_from_ending(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("boxes") / "boxes"
    path.write_bytes(data)
    assert lacks_index(path) in (True, False)
