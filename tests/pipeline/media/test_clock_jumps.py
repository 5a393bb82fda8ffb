"""A clock that jumps goes on: no frame and no sound is lost, and they stay together."""

from fractions import Fraction
from itertools import pairwise

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, process_video
from makeup_video.pipeline.media.clock_jumps import is_jump
from media import add_video, encode_frames, packets_of, times_of, tone


def recording(path, begins, frames=60):
    """A stream of 30 frames a second with sound, whose clock begins at some second."""
    with av.open(str(path), "w", container_options={"mpegts_copyts": "1", "muxdelay": "0"}) as out:
        video = add_video(out, "h264", time_base=Fraction(1, 90000))
        audio = out.add_stream("aac", rate=48000, layout="stereo")
        encode_frames(out, video, [begins * 90000 + 3000 * i for i in range(frames)])
        tone(out, audio, frames / 30, start_seconds=begins)
    return path.read_bytes()


def joined(folder, *begins):
    src = folder / "in.ts"
    src.write_bytes(b"".join(recording(folder / "part.ts", at) for at in begins))
    return src


@pytest.mark.parametrize("begins", [(4, 0), (0, 50), (7, 0, 90)], ids=str)
@pytest.mark.parametrize("name", ["out.mp4", "out.mkv"])
def test_nothing_is_lost_where_the_clock_jumps(tmp_path, name, begins):
    src, out = joined(tmp_path, *begins), tmp_path / name
    report = process_video(src, out)
    assert report.frames_out == 60 * len(begins) and not report.damaged
    assert (
        sum("since the clock jumps there" in text for text in report.converted) == len(begins) - 1
    )
    assert len(packets_of(out, "audio")) == len(packets_of(src, "audio"))
    for times in (times_of(out), [seconds for seconds, _ in packets_of(out, "audio")]):
        assert max(b - a for a, b in pairwise(times)) < 0.2
        assert times[-1] == pytest.approx(2 * len(begins), abs=0.3)


def test_sound_and_picture_stay_together_after_a_jump(tmp_path):
    src, out = joined(tmp_path, 4, 0), tmp_path / "out.mkv"
    process_video(src, out)
    sound = [seconds for seconds, _ in packets_of(out, "audio")]
    whole = packets_of(tmp_path / "part.ts", "audio")
    first = sound[len(sound) - len(whole)]  # of the second recording
    assert first - times_of(out)[60] == pytest.approx(
        whole[0][0] - times_of(tmp_path / "part.ts")[0], abs=0.002
    )


def test_a_film_whose_clock_jumps_is_painted_whole(tmp_path):
    src = joined(tmp_path, 4, 0)
    report = process_video(src, tmp_path / "out.mp4", None, Settings(split_minutes=Fraction(1, 60)))
    assert report.frames_out == 120 and "clock jumps" in report.why_whole


@given(st.fractions(min_value=-1, max_value=10))
def test_a_step_of_frames_is_no_jump(step):
    assert is_jump(step) == (step in (-1, 10))
    assert is_jump(-1 - abs(step)) and is_jump(10 + abs(step))
