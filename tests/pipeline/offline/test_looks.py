"""Several looks of one video or picture: the same files as separate runs write, read only once."""

import os
import signal
import time
from collections import Counter
from contextlib import closing
from pathlib import Path

import av
import cv2
import pytest
from makeup_video.pipeline import (
    Look,
    MakeupVideoError,
    OutputError,
    Settings,
    StoppedError,
    TooLittleMemoryError,
    UsageError,
    process_looks,
    process_video,
    product,
    ready_look,
)
from makeup_video.pipeline.engine import machine
from makeup_video.pipeline.engine.fan_out import FanOut
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.look.options import Choice, choose_look
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.offline import looks as looks_module
from makeup_video.pipeline.offline import looks_on_video
from people import SAMPLES, clip, grey, write_video
from rich_clips import rich_clip

BERRY = Look(lips=product((120, 10, 60), "satin"))
PLUM = Look(lips=product((90, 20, 80), "gloss"), eyes=product((80, 40, 90), "shimmer"))
LOOKS = {"berry": BERRY, "plum": PLUM, "cat": ready_look("cat-eye").look, "none": Look()}


def paths_of(folder, end, looks=LOOKS):
    return {folder / f"{name}{end}": look for name, look in looks.items()}


def content_of(path):
    """The bytes of a file; of Matroska, which holds random numbers, every packet and tag."""
    if path.suffix not in (".mkv", ".webm"):
        return path.read_bytes()
    with av.open(str(path)) as box:
        packets = [(p.stream.index, p.pts, p.dts, p.duration, bytes(p)) for p in box.demux()]
        streams = [(s.type, s.name, s.metadata, s.disposition) for s in box.streams]
        return packets, streams, box.metadata, box.chapters()


def assert_same_as_separate_runs(tmp_path, src, end, settings, looks=LOOKS):
    many, single = tmp_path / "many", tmp_path / "single"
    for folder in (many, single):
        folder.mkdir()
    done = process_looks(src, paths_of(many, end, looks), settings)
    for path, look in paths_of(single, end, looks).items():
        report = process_video(src, path, look, settings)
        assert content_of(path) == content_of(many / path.name)
        mine = done[many / path.name]
        for name in ("frames_out", "dropped", "converted", "conversions", "damaged", "bytes_in",
                     "bytes_out", "codec", "media_seconds"):  # fmt: skip
            assert getattr(mine, name) == getattr(report, name), name
        if not look.is_bare:  # process_video finds no faces for a bare look
            assert (mine.faces, mine.painted_frames) == (report.faces, report.painted_frames)
            assert mine.warnings() == report.warnings()


@pytest.mark.parametrize(
    ("end", "settings"),
    [
        (".mp4", Settings()),
        (".mkv", Settings(codec="ffv1", compare=True)),
        (".webm", Settings(preset="8", bit_depth=8)),
        (".mov", Settings(codec="prores")),
        (".mp4", Settings(codec="hevc", preset="ultrafast", faces="0")),
    ],
)  # fmt: skip
def test_the_files_are_those_of_separate_runs(tmp_path, end, settings):
    src = write_video(tmp_path / "in.mkv", clip(8))
    assert_same_as_separate_runs(tmp_path, src, end, settings)


@pytest.mark.parametrize("end", [".mp4", ".mkv", ".webm", ".mov"])
@pytest.mark.parametrize("sound", [("flac", "aac"), ("mp3", "libopus")])
def test_other_streams_are_copied_and_converted_alike(tmp_path, end, sound):
    src = rich_clip(tmp_path / "in.mkv", sound, "subrip")
    preset = "8" if end == ".webm" else "ultrafast"
    looks = {"one": BERRY, "two": PLUM, "three": Look()}
    assert_same_as_separate_runs(tmp_path, src, end, Settings(preset=preset), looks)


def test_a_part_of_a_video_with_sound_is_cut_alike(tmp_path):
    src = rich_clip(tmp_path / "in.mkv", ("flac", "aac"), "subrip")
    settings = Settings(start_seconds=looks_module.Fraction(1, 5), preset="ultrafast")
    assert_same_as_separate_runs(tmp_path, src, ".mp4", settings)


def test_more_looks_than_fit_into_memory_take_several_passes(tmp_path, monkeypatch):
    monkeypatch.setattr(looks_module, "_MOST_AT_ONCE", 2)
    src = write_video(tmp_path / "in.mkv", clip(6))
    assert_same_as_separate_runs(tmp_path, src, ".mkv", Settings(codec="ffv1"))


@pytest.mark.parametrize(
    ("free_mb", "codec", "count"),
    [(0, "h264", 1), (60, "h264", 1), (180, "h264", 3), (100_000, "h264", 16), (180, "av1", 1)],
)
def test_half_of_the_free_memory_is_given_to_encoders(tmp_path, monkeypatch, free_mb, codec, count):
    monkeypatch.setattr(looks_module, "free_memory_bytes", lambda: free_mb * 1_000_000)
    src = write_video(tmp_path / "in.mkv", [grey(640, 360)])
    source = looks_module.open_video(src)
    settings = Settings(codec=codec)
    assert looks_module.encoders_at_once(source, tmp_path / "a.mp4", settings) == count
    source.close()


def test_encoders_of_before_and_after_need_twice_the_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(looks_module, "free_memory_bytes", lambda: 360_000_000)
    src = write_video(tmp_path / "in.mkv", [grey(640, 360)])
    with closing(looks_module.open_video(src)) as source:
        for compare, count in ((False, 6), (True, 3)):
            settings = Settings(codec="h264", compare=compare)
            assert looks_module.encoders_at_once(source, tmp_path / "a.mp4", settings) == count


@pytest.mark.parametrize("name", ["in.jpg", "in.png"])
@pytest.mark.parametrize("end", [".jpg", ".png", ".webp"])
@pytest.mark.parametrize("compare", [False, True])
def test_pictures_are_those_of_separate_runs(tmp_path, name, end, compare):
    src = tmp_path / name
    cv2.imwrite(str(src), cv2.imread(str(SAMPLES / "portrait.jpg"))[::4, ::4])
    assert_same_as_separate_runs(tmp_path, src, end, Settings(compare=compare))


def test_faces_are_found_once_for_all_looks(tmp_path, monkeypatch):
    runs, call = Counter(), Net.__call__

    def counted(self, *args, **more):
        runs[count] += 1
        return call(self, *args, **more)

    monkeypatch.setattr(Net, "__call__", counted)
    src = write_video(tmp_path / "in.mkv", clip(5))
    for count in (1, 4):
        folder = tmp_path / str(count)
        folder.mkdir()
        looks = dict(list(LOOKS.items())[:count])
        process_looks(src, paths_of(folder, ".mkv", looks), Settings(codec="ffv1"))
    assert runs[1] == runs[4] > 5


def test_looks_of_one_pass_have_the_seconds_of_the_pass(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(2))
    done = process_looks(src, paths_of(tmp_path, ".mkv"), Settings(codec="ffv1"))
    assert len({(one.seconds, one.cpu_seconds) for one in done.values()}) == 1


def test_several_looks_are_not_split(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(2))
    settings = Settings(split_minutes=looks_module.Fraction(1))
    with pytest.raises(UsageError, match="leave out split_minutes, or paint each look"):
        process_looks(src, paths_of(tmp_path, ".mkv"), settings)
    assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]


@pytest.mark.parametrize("end", [".mkv", ".mp4"])
def test_an_error_of_one_look_ends_that_look_alone(tmp_path, end):
    src = write_video(tmp_path / "in.mkv", clip(40))
    looks = paths_of(tmp_path, end, {"a": BERRY, "b": PLUM, "c": BERRY})
    lost = tmp_path / f"b.part{end}"

    def tick(outputs, *figures):
        assert outputs == list(looks)
        lost.unlink(missing_ok=True)  # as another program may do

    done = process_looks(src, looks, Settings(preset="ultrafast"), tick)
    a, b, c = done.values()
    assert isinstance(b, OutputError) and "removed or replaced" in str(b)
    assert (a.frames_out, c.frames_out) == (40, 40)
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"a{end}", f"c{end}", "in.mkv"]


def test_the_part_of_a_look_that_failed_makes_room_at_once(tmp_path, monkeypatch):
    """On a full disk, the other outputs need the room."""
    src, encode, parts = write_video(tmp_path / "in.mkv", clip(30)), VideoEncoder.__call__, []

    def full(self, frame):
        if self is encoders[0] and frame.pts > 300:
            raise OutputError("No space left on device")
        encode(self, frame)
        if frame is not None and self is encoders[1]:
            parts.append((tmp_path / "a.part.mkv").exists())

    encoders, init = [], VideoEncoder.__init__

    def counted(self, *words, **more):
        init(self, *words, **more)
        encoders.append(self)

    monkeypatch.setattr(VideoEncoder, "__init__", counted)
    monkeypatch.setattr(VideoEncoder, "__call__", full)
    looks = paths_of(tmp_path, ".mkv", {"a": BERRY, "b": PLUM})
    a, b = process_looks(src, looks, Settings(codec="ffv1")).values()
    assert isinstance(a, OutputError) and b.frames_out == 30
    assert parts[0] and not parts[-1]


@pytest.mark.parametrize("lost", ["one", "all"])
def test_an_error_of_a_later_pass_leaves_the_earlier_ones(tmp_path, monkeypatch, lost):
    monkeypatch.setattr(looks_module, "_MOST_AT_ONCE", 2)
    src, looks = write_video(tmp_path / "in.mkv", clip(6)), paths_of(tmp_path, ".mkv")
    paint = looks_on_video.paint_video

    def first_pass(*words):
        done = paint(*words)
        if lost == "one":
            (tmp_path / "none.mkv").write_text("mine")
        else:
            src.unlink()
        return done

    monkeypatch.setattr(looks_on_video, "paint_video", first_pass)
    done = process_looks(src, looks, Settings(codec="ffv1"))
    assert list(done) == list(looks)
    failed = {path.stem: one for path, one in done.items() if isinstance(one, MakeupVideoError)}
    assert set(failed) == ({"none"} if lost == "one" else {"cat", "none"})
    assert all((tmp_path / f"{name}.mkv").exists() for name in ("berry", "plum"))
    if lost == "one":
        assert "exists already" in str(failed["none"])
        assert (tmp_path / "none.mkv").read_text() == "mine"


def test_ctrl_c_while_a_pass_is_finished_ends_the_next_ones(tmp_path, monkeypatch):
    monkeypatch.setattr(looks_module, "_MOST_AT_ONCE", 2)
    src, finish = write_video(tmp_path / "in.mkv", clip(6)), FanOut.finish

    def interrupted(self, stopped):
        finish(self, stopped)
        signal.raise_signal(signal.SIGINT)
        time.sleep(0.5)

    monkeypatch.setattr(FanOut, "finish", interrupted)
    with pytest.raises(StoppedError):
        process_looks(src, paths_of(tmp_path, ".mkv"), Settings(codec="ffv1"))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["berry.mkv", "in.mkv", "plum.mkv"]


@pytest.mark.parametrize("name", ["in.mkv", "in.jpg"])
def test_all_outputs_are_whole_before_it_is_told(tmp_path, name):
    src, end, there = tmp_path / name, os.path.splitext(name)[1], []
    if end == ".jpg":
        cv2.imwrite(str(src), clip(1)[0])
    else:
        write_video(src, clip(2))
    settings = Settings(on_whole=lambda: there.append(len(list(tmp_path.iterdir())) - 1))
    process_looks(src, paths_of(tmp_path, end), settings)
    assert there == [len(LOOKS)]


def test_where_no_output_is_whole_nobody_is_told(tmp_path):
    src, told = write_video(tmp_path / "in.mkv", clip(20)), []
    looks = paths_of(tmp_path, ".mkv", {"a": BERRY, "b": PLUM})

    def tick(outputs, *figures):
        for name in "ab":
            (tmp_path / f"{name}.part.mkv").unlink(missing_ok=True)  # as another program may do

    settings = Settings(preset="ultrafast", on_whole=lambda: told.append(True))
    done = process_looks(src, looks, settings, tick)
    assert [type(outcome) for outcome in done.values()] == [OutputError, OutputError]
    assert told == []


def test_ctrl_c_ends_all_looks_and_leaves_playable_parts(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(40))

    def tick(outputs, done, *figures):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(StoppedError):
        process_looks(src, paths_of(tmp_path, ".mkv"), Settings(codec="ffv1"), tick)
    for name in LOOKS:
        assert cv2.VideoCapture(str(tmp_path / f"{name}.part.mkv")).get(7) > 0


@pytest.mark.parametrize("name", ["in.mkv", "in.jpg"])
def test_outputs_are_refused_before_any_is_begun(tmp_path, name):
    src, end = tmp_path / name, os.path.splitext(name)[1]
    if end == ".jpg":
        cv2.imwrite(str(src), clip(1)[0])
    else:
        write_video(src, clip(2))
    (tmp_path / f"b{end}").write_text("mine")
    for looks, message in [
        ({}, "no look given"),
        ({f"a{end}": BERRY, f"b{end}": PLUM}, "exists already"),
        ({f"a{end}": BERRY, f"A{end}": PLUM}, "one file"),
        ({f"a{end}": BERRY, name: PLUM}, "is the input"),
        ({f"a{end}": BERRY, "c.txt": PLUM}, "must end in|one extension"),
        ({f"a{end}": BERRY, "no/c.mkv": PLUM}, "does not exist"),
    ]:
        with pytest.raises((UsageError, OutputError), match=message):
            process_looks(src, {tmp_path / key: look for key, look in looks.items()})
        assert sorted(p.name for p in tmp_path.iterdir()) == sorted([name, f"b{end}"])


def test_a_gone_face_number_is_explained_for_each_look(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(4))
    looks = paths_of(tmp_path, ".mkv", {"a": BERRY, "b": choose_look(Choice(worn={"lips": "tan"}))})
    done = process_looks(src, looks, Settings(codec="ffv1", faces="7"))
    for report in done.values():
        assert report.warnings() == [
            "nothing was painted: face 7 was chosen, but the only face seen was 0"
        ]


def test_one_file_that_is_spelled_twice_is_two_outputs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for other in ("./out.mp4", Path("out.mp4"), tmp_path / "out.mp4"):
        with pytest.raises(UsageError, match=r"two outputs (have the name|are one file)"):
            process_looks(SAMPLES / "in.mp4", {"out.mp4": BERRY, other: PLUM})
    with pytest.raises(TypeError, match="looks must be a dict"):
        process_looks(SAMPLES / "in.mp4", [BERRY])


@pytest.mark.parametrize("name", ["in.png", "in.mkv"])
def test_memory_that_only_finds_faces_is_too_little(tmp_path, monkeypatch, name):
    src = tmp_path / name
    if name == "in.png":
        src.write_bytes((SAMPLES / "portrait.jpg").read_bytes())
    else:
        write_video(src, clip(1))
    monkeypatch.setattr(machine, "cores", lambda: 2)
    monkeypatch.setattr(machine, "_address_limit_bytes", lambda: 1_120_000_000)
    with pytest.raises(TooLittleMemoryError, match=r"^painting this (picture|video)"):
        process_looks(src, paths_of(tmp_path, src.suffix))
    assert [path.name for path in tmp_path.iterdir()] == [name]
