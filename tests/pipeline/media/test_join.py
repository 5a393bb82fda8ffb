"""Decoding times of joined segments: those that one encoder would give."""

from fractions import Fraction
from itertools import accumulate, pairwise
from pathlib import Path

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import EncodeError, OutputError
from makeup_video.pipeline.media.join import Join, decoding_times
from makeup_video.pipeline.media.segment_file import PacketTime, SegmentFile
from media import add_video, picture

STEPS = st.lists(st.integers(1, 50), min_size=1, max_size=60)


def encoded(shown, delay):
    """The times of an encoder that swaps pictures in groups of up to `delay` after the first."""
    order = shown[:1]
    for begin in range(1, len(shown), delay + 1):
        *before, last = shown[begin : begin + delay + 1]
        order += [last, *before]
    early = shown[min(delay, len(shown) - 1)] - shown[0]
    decoded = [*(time - early for time in shown[:delay]), *shown]
    return tuple(PacketTime(pts, dts, 1) for pts, dts in zip(order, decoded, strict=False))


def segment(times, headers=b"sets"):
    return SegmentFile(Path("segment-00001"), "nut", Fraction(1, 1000), headers, times)


@given(st.integers(0, 4), STEPS, st.data())
def test_times_do_not_depend_on_where_the_video_is_split(delay, steps, data):
    shown = list(accumulate(steps))
    cuts = data.draw(st.sets(st.integers(1, max(1, len(shown) - 1)), max_size=4))
    places = [0, *sorted(cut for cut in cuts if cut < len(shown)), len(shown)]
    files = [segment(encoded(shown[a:b], delay)) for a, b in pairwise(places)]
    times = list(decoding_times(files))
    assert all(a < b for a, b in pairwise(times))
    packets = [time for file in files for time in file.times]
    assert all(dts <= packet.pts for dts, packet in zip(times, packets, strict=True))
    if max(b - a for a, b in pairwise(places)) > delay:
        assert times == [time.dts for time in encoded(shown, delay)]


def test_segments_of_another_encoder_are_refused():
    class Encoder:
        headers = b"other sets"

    with pytest.raises(EncodeError, match="has other parameter sets than the output"):
        Join(None, Encoder(), None).finish([segment(())])


def test_a_segment_that_lost_packets_is_not_taken_for_whole(tmp_path):
    path = tmp_path / "segment-00001"
    with av.open(str(path), "w", format="nut") as out:
        stream = add_video(out, "ffv1")
        for index in range(3):
            frame = picture(index, 96, 64)
            frame.pts, frame.time_base = index, Fraction(1, 30)
            out.mux(stream.encode(frame))
    times = tuple(PacketTime(n, n, 1) for n in range(4))
    file = SegmentFile(path, "nut", Fraction(1, 30), b"", times)
    with pytest.raises(OutputError, match="has 3 packets, but 4 were written"):
        list(file.packets())
    path.write_bytes(b"not a video")
    with pytest.raises(OutputError, match="cannot be read back"):
        list(file.packets())
