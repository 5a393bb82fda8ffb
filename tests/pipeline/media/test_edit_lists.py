"""Edit lists of mp4 and mov: what they hide is no damage, and what they show is kept."""

import struct

import av
import pytest
from makeup_video.pipeline import process_video
from media import decoded, make_clip, packets_of, times_of

NORMAL = 1 << 16  # the speed of an edit


def with_edits(path, *edits):
    """Give each track of an mp4 with its index last a list of edits, (milliseconds, first tick)."""
    data, tracks = path.read_bytes(), iter(edits)
    at = data.index(b"moov") - 4

    def rebuilt(boxes):
        out, begin = b"", 0
        while begin < len(boxes):
            size, kind = struct.unpack_from(">I4s", boxes, begin)
            body = boxes[begin + 8 : begin + size]
            if kind == b"trak":
                body = rebuilt(body)
            elif kind == b"edts":
                track = next(tracks)
                spans = b"".join(struct.pack(">Iii", *edit, NORMAL) for edit in track)
                body = struct.pack(">I4sII", 16 + len(spans), b"elst", 0, len(track)) + spans
            out += struct.pack(">I4s", 8 + len(body), kind) + body
            begin += size
        return out

    index = rebuilt(data[at + 8 :])
    path.write_bytes(data[:at] + struct.pack(">I4s", 8 + len(index), b"moov") + index)
    return path


def cut_twice(path, audio):
    """A video of three seconds whose edits show the first and the third."""
    make_clip(path, frames=90, audio=audio, options={"bf": "0", "g": "30"})
    first = 1024 if audio == "aac" else 0
    return with_edits(
        path,
        [(1000, 0), (1000, 2 * 15360)],
        [(1000, first), (1000, 2 * 48000 + first)],
    )


@pytest.mark.parametrize("audio", ["aac", "pcm_s16le"])
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_a_video_with_two_edits_is_not_damaged(tmp_path, audio, end):
    src, out = cut_twice(tmp_path / "in.mov", audio), tmp_path / f"out{end}"
    assert len(decoded(src)) == 60 and len(packets_of(src, "audio")) > 94
    report = process_video(src, out)
    assert (report.frames_out, report.skipped_packets, report.damaged) == (60, 0, False)
    assert float(times_of(out)[-1]) == pytest.approx(59 / 30, abs=0.001)
    times = [seconds for seconds, _ in packets_of(out, "audio")]
    assert times == sorted(times)
    with av.open(str(out)) as container:
        samples = sum(frame.samples for frame in container.decode(audio=0))
    assert samples / 48000 == pytest.approx(2, abs=0.05)


@pytest.mark.parametrize("cut_ms", [1000, 1800])
def test_a_video_that_begins_late_and_is_cut_ends_at_the_cut(tmp_path, cut_ms):
    """FFmpeg's length of such a track counts the delay twice."""
    path = make_clip(tmp_path / "in.mp4", frames=90, options={"bf": "0", "g": "30"})
    src, out = with_edits(path, [(500, -1), (cut_ms, 0)]), tmp_path / "out.mp4"
    report = process_video(src, out)
    assert report.frames_out == round(cut_ms * 0.03)
    assert report.media_seconds == pytest.approx(cut_ms / 1000, abs=0.001)
