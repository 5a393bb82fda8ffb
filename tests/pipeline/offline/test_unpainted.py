"""If the whole look, or a part of it, was painted nowhere, one warning gives the reason."""

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import KINDS, Layer, Look, Settings, process_video, product
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.stages import PaintRun
from makeup_video.pipeline.render import composite
from media import make_clip
from people import SAMPLES, clip, face_of, grey, put, veiled, write_video

BLUE = Look(lips=product((10, 42, 140), "matte"))
TURN = "if the {} is upside down, turn it first"


def only_line(src, look=BLUE, **settings):
    report = process_video(src, src.with_name(f"out{src.suffix}"), look, Settings(**settings))
    assert report.painted_frames == 0 and report.damaged is False
    (line,) = report.warnings()
    return line


def saved(path, rgb8):
    cv2.imwrite(str(path), rgb8[..., ::-1])
    return path


def test_an_unknown_number_is_shown_with_those_seen(tmp_path):
    one_face = put(grey(), face_of(110), 320, 60)
    src = saved(tmp_path / "one.png", one_face)
    assert only_line(src, faces="1") == (
        "nothing was painted: face 1 was chosen, but the only face seen was 0"
    )
    src = saved(tmp_path / "two.png", put(one_face, face_of(80), 40, 60))
    assert only_line(src, faces="2", overwrite=True) == (
        "nothing was painted: face 2 was chosen, but the faces seen were 0 and 1"
    )


def test_a_video_too_lists_the_faces_seen(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(6))
    assert only_line(src, faces="3", codec="ffv1") == (
        "nothing was painted: face 3 was chosen, but the only face seen was 0"
    )


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({4}, "the only face seen was 4"),
        ({2, 0}, "the faces seen were 0 and 2"),
        (set(range(10)), "the faces seen were 0, 1, 2, 3, 4, 5, 6, 7, 8 and 9"),
        (set(range(500)), "the faces seen were 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 490 more"),
        (set(), "no face was seen for long"),
    ],
)
def test_at_most_ten_faces_are_named(numbers, words):
    run = PaintRun(BLUE, "999")
    run(None)
    run.composite.numbers = numbers
    run._found.frames_with_face = run._found.faces = 3
    report = Report("in.png", "out.png", "png", is_picture=True)
    run.count(report)
    assert report.warnings() == [f"nothing was painted: face 999 was chosen, but {words}"]


def test_a_hidden_face_is_explained_by_what_is_hidden(tmp_path, monkeypatch):
    monkeypatch.setattr(composite, "jobs_of", lambda *_: [])
    src = saved(tmp_path / "in.png", face_of(200))
    shadow = product((0, 90, 40), "matte", "eyes")
    for look, parts in (
        (BLUE, "mouth"),
        (Look(eyes=shadow), "eyes"),
        (Look(lips=BLUE.lips, eyes=shadow), "mouth or eyes"),
        (Look([Layer("blush", shadow)]), KINDS["blush"].must_see),
    ):
        reason = f"no {parts} could be seen in the faces found; {TURN.format('picture')}"
        assert only_line(src, look, overwrite=True) == f"nothing was painted: {reason}"


@pytest.mark.parametrize("suffix", [".png", ".mkv"])
def test_a_part_that_is_nowhere_seen_is_named(tmp_path, suffix):
    rgb8 = veiled(put(grey(), face_of(200), 200, 20))
    src = tmp_path / f"in{suffix}"
    src = saved(src, rgb8) if suffix == ".png" else write_video(src, [rgb8] * 6)
    look = Look(lips=BLUE.lips, eyes=product((0, 90, 40), "matte", "eyes"))
    report = process_video(src, tmp_path / f"out{suffix}", look)
    assert report.painted_frames == report.frames_in
    assert report.warnings() == ["not all was painted: no mouth could be seen in the faces found"]


@pytest.mark.parametrize(
    ("faces", "words"), [("0", "face 0"), ("largest", "the largest face"), ("1", ""), ("all", "")]
)
def test_a_part_counts_only_in_the_faces_that_were_chosen(tmp_path, faces, words):
    rgb8 = veiled(put(grey(), face_of(200), 40, 20))
    src = saved(tmp_path / "in.png", put(rgb8, face_of(120), 420, 60))
    look = Look(lips=BLUE.lips, eyes=product((0, 90, 40), "matte", "eyes"))
    report = process_video(src, tmp_path / "out.png", look, Settings(faces=faces))
    line = f"not all was painted: no mouth could be seen in {words}"
    assert report.warnings() == ([line] if words else [])


def test_a_look_that_changes_nothing_is_the_reason(tmp_path):
    nothing = dict.fromkeys(("red", "green", "blue", "opacity", "gloss", "reflection"), 0)
    look = Look.from_dict({"version": 1, "lips": {**nothing, "gloss_roughness": 0.5}, "eyes": None})
    assert not look.is_bare
    line = only_line(saved(tmp_path / "in.png", face_of(200)), look)
    assert line == "nothing was painted: the look has no opacity, no gloss and no reflection"


def test_where_no_face_was_found_turning_may_help(tmp_path):
    line = "no face was found: nothing was painted; " + TURN
    assert only_line(make_clip(tmp_path / "in.mp4")) == line.format("video")
    assert only_line(saved(tmp_path / "in.png", grey())) == line.format("picture")


def test_a_video_that_is_upside_down_is_painted(tmp_path):
    frames = [np.ascontiguousarray(np.rot90(rgb8, 2)) for rgb8 in clip(12)]
    src = write_video(tmp_path / "in.mkv", frames)
    report = process_video(src, tmp_path / "out.mkv", BLUE, Settings(codec="ffv1"))
    assert report.painted_frames == report.frames_in == 12 and report.warnings() == []


def test_a_video_whose_header_turns_it_is_painted(tmp_path):
    src = make_turned(tmp_path / "in.mp4")
    report = process_video(src, tmp_path / "out.mp4", BLUE)
    assert report.painted_frames == report.frames_in == 12 and report.warnings() == []


def make_turned(path):
    import av

    with av.open(str(path), "w") as out:
        stream = out.add_stream("libx264", rate=30, options={"preset": "ultrafast", "crf": "10"})
        stream.width, stream.height, stream.pix_fmt = 640, 360, "yuv420p"
        stream.set_display_rotation(180)
        for rgb8 in clip(12):
            turned = np.ascontiguousarray(np.rot90(rgb8, 2))
            out.mux(stream.encode(av.VideoFrame.from_ndarray(turned, format="rgb24")))
        out.mux(stream.encode(None))
    return path


def test_small_faces_are_reported_by_their_size_alone():
    report = Report("in.mp4", "o.mp4", "h264", painted_frames=0, frames_with_face=0, tiny_faces=3)
    assert report.warnings() == [
        "no face was found: nothing was painted",
        "faces under 40 px wide were not painted (3 seen)",
    ]


def test_the_sample_is_painted_without_warnings(tmp_path):
    report = process_video(SAMPLES / "portrait.jpg", tmp_path / "out.jpg", BLUE)
    assert report.warnings() == [] and report.why_unpainted == ""
