"""Runs that search for faces: their stages, their counts, and when the stages are created."""

import cv2
import pytest
from makeup_video.pipeline import InputError, OutputError, Settings, UsageError
from makeup_video.pipeline.engine.machine import one_opencv_thread
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.run import run_stages
from makeup_video.pipeline.offline.stages import FaceRun
from people import SAMPLES, clip, face_of, frame_of, grey, put, write_video


def pass_on(item):
    return item.frame


def test_a_picture_is_searched_once_and_counted():
    run = FaceRun(lambda: [("rest", pass_on)], paints=False)
    (_, find), (name, rest) = run(None)
    assert name == "rest"
    two_faces = put(put(grey(), face_of(80), 40, 60), face_of(110), 320, 60)
    assert rest(find(frame_of(two_faces))) is not None
    report = Report("in", "out", "png")
    run.count(report)
    assert (report.faces, report.frames_with_face, report.tiny_faces) == (2, 1, 0)
    assert report.painted_frames is None


def test_a_video_is_followed_and_counted(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(5))
    run = FaceRun(lambda: [("rest", pass_on)], paints=False)
    report = run_stages(src, tmp_path / "out.mkv", run, Settings(), None)
    run.count(report)
    assert list(report.stages) == ["decode", "faces", "smooth", "rest", "encode"]
    assert (report.faces, report.frames_with_face, report.frames_out) == (1, 5, 5)


@pytest.mark.parametrize("name", ["in.mkv", "in.jpg"])
def test_the_rest_is_made_between_input_and_output(tmp_path, name):
    def rest():
        files_at_creation.append(sorted(path.name for path in tmp_path.iterdir()))
        raise UsageError("no such device")

    def run():
        stages = FaceRun(rest, paints=False)
        run_stages(tmp_path / name, tmp_path / f"out.{name}", stages, Settings(), None)

    files_at_creation = []
    with pytest.raises(InputError):
        run()
    assert files_at_creation == []
    if name == "in.jpg":
        (tmp_path / name).write_bytes((SAMPLES / "portrait.jpg").read_bytes())
    else:
        write_video(tmp_path / name, clip(1))
    with pytest.raises(UsageError, match="no such device"):
        run()
    assert files_at_creation == [[name]]
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_an_impossible_output_is_still_refused(tmp_path):
    src = write_video(tmp_path / "in.mkv", clip(1))
    run = FaceRun(lambda: [("rest", pass_on)], paints=False)
    with pytest.raises(OutputError):
        run_stages(src, tmp_path / "no" / "out.mkv", run, Settings(), None)


def test_opencv_gets_its_threads_back_after_a_run():
    before = cv2.getNumThreads()
    cv2.setNumThreads(2)
    try:
        with pytest.raises(KeyError), one_opencv_thread():
            assert cv2.getNumThreads() == 1
            raise KeyError
        assert cv2.getNumThreads() == 2
    finally:
        cv2.setNumThreads(before)
