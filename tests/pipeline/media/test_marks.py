"""Marks of streams, such as forced or default: kept, or named where a container has none."""

import av
import pytest
from av.stream import Disposition
from makeup_video.pipeline import Settings, StrictError, process_video
from media import add_video, encode_frames, tone
from rich_clips import add_titles, write_titles

PLAIN = Disposition(0)


def marked_video(path, sound=PLAIN, titles=(PLAIN,)):
    with av.open(str(path), "w") as out:
        video, audio = add_video(out), out.add_stream("aac", rate=48000, layout="stereo")
        texts = [add_titles(out, "subrip") for _ in titles]
        audio.disposition = sound
        for text, mark in zip(texts, titles, strict=True):
            text.disposition = mark
        encode_frames(out, video, range(30))
        tone(out, audio, 1)
        for text in texts:
            write_titles(out, text)
    return path


def marks_of(path, kind):
    with av.open(str(path)) as container:
        return [stream.disposition for stream in container.streams if stream.type == kind]


MARKS = [mark for mark in Disposition if mark.name not in ("attached_pic", "timed_thumbnails")]


@pytest.mark.parametrize("mark", MARKS, ids=lambda mark: mark.name)
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_every_mark_of_a_stream_is_kept_or_named(tmp_path, mark, end):
    src, out = marked_video(tmp_path / "in.mkv", mark, (mark,)), tmp_path / f"out{end}"
    report = process_video(src, out)
    for kind in ("audio", "subtitle"):
        (before,), (after,) = marks_of(src, kind), marks_of(out, kind)
        named = [line for line in report.dropped if line.startswith(kind)]
        assert bool(before & ~after) == bool(named) and len(named) <= 1
        assert all(str(mark.name).replace("_", " ") in line for line in named)


def test_strict_refuses_a_container_without_the_mark(tmp_path):
    src = marked_video(tmp_path / "in.mkv", titles=(Disposition.forced,))
    with pytest.raises(StrictError, match=r"subtitle #2 \(srt\): mov cannot mark it as forced"):
        process_video(src, tmp_path / "out.mov", None, Settings(strict=True))


@pytest.mark.parametrize("shown", [0, 1, None])
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_subtitles_that_are_off_stay_off(tmp_path, shown, end):
    marks = [Disposition.default if number == shown else PLAIN for number in range(2)]
    src = marked_video(tmp_path / "in.mkv", Disposition.default, marks)
    report = process_video(src, tmp_path / f"out{end}")
    assert marks_of(tmp_path / f"out{end}", "subtitle") == marks and report.dropped == []
    assert marks_of(tmp_path / f"out{end}", "audio") == [Disposition.default]
