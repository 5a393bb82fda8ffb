"""Side data equals FFmpeg's, and reading it does not keep a picture alive."""

import gc
import struct

import av
from makeup_video.pipeline.frames.side_data import all_side_data, side_data
from media import add_video, encode_frames

WIDTH = 336  # px: no other test has pictures of this width


def turned_video(path):
    with av.open(str(path), "w") as out:
        stream = add_video(out, size_wh=(WIDTH, 48))
        stream.set_display_rotation(90)
        encode_frames(out, stream, range(3))
    return path


def test_the_bytes_are_those_of_the_picture(tmp_path):
    with av.open(str(turned_video(tmp_path / "in.mp4"))) as container:
        picture = next(container.decode(video=0))
    matrix = side_data(picture, "DISPLAYMATRIX")
    assert matrix == bytes(picture.side_data["DISPLAYMATRIX"]) and len(matrix) == 36
    assert struct.unpack("9i", matrix)[0] == 0  # a turn by a right angle
    assert side_data(picture, "A53_CC") is None
    assert [kind.name for kind in all_side_data(picture)] == [
        data.type.name for data in picture.side_data
    ]


def test_no_picture_waits_for_the_garbage_collector(tmp_path):
    path = turned_video(tmp_path / "in.mp4")
    gc.collect()
    gc.disable()
    try:
        with av.open(str(path)) as container:
            for picture in container.decode(video=0):
                assert side_data(picture, "DISPLAYMATRIX")
        del picture
        pictures = [one for one in gc.get_objects() if isinstance(one, av.VideoFrame)]
        assert not [one for one in pictures if one.width == WIDTH]
    finally:
        gc.enable()
