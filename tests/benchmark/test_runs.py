"""One run of each kind of benchmark. Nothing here is timed."""

import pytest
from makeup_video.benchmark import harness, runs
from makeup_video.pipeline import InputError, Look, product
from makeup_video.pipeline.offline import encoding
from makeup_video.pipeline.offline import video as offline_video
from people import clip, grey, write_video

LOOK = Look(lips=product((150, 30, 70), "satin"), eyes=product((60, 80, 150), "satin", "eyes"))


@pytest.mark.parametrize(("painted", "frames"), [(0, 1), (94, 100), (None, 10)])
def test_a_run_that_painted_too_few_frames_is_refused(painted, frames):
    with pytest.raises(InputError, match=f"in {painted or 0} of {frames} frames, at least 95%"):
        runs.check_painted(painted, frames)


def test_a_run_that_painted_95_of_100_frames_is_measured():
    runs.check_painted(95, 100)


def test_a_video_where_the_face_leaves_is_refused(tmp_path):
    source = write_video(tmp_path / "leaves.mkv", [*clip(20), *[grey()] * 10])
    with pytest.raises(InputError, match="of 30 frames"):
        runs.run_product(source, tmp_path / "out.mp4", LOOK)
    run, report = runs.run_product(source, tmp_path / "out.mp4", None)
    assert run.frames == report.frames_out == 30


def test_nobody_need_be_seen_in_an_excerpt(tmp_path):
    source = write_video(tmp_path / "comes.mkv", [*[grey()] * 10, *clip(20)])
    look = ("--look", "cat-eye")
    assert runs.run_command(source, tmp_path / "o.mp4", look, words=("--end", "0.2"))["frames_out"]
    with pytest.raises(InputError, match="of 30 frames"):
        runs.run_command(source, tmp_path / "out.mp4", look)


def test_the_bare_loop_encodes_every_frame(tmp_path):
    source = write_video(tmp_path / "a.mkv", clip(10))
    run = runs.run_bare(source, tmp_path / "out.mp4", (1, 2))
    assert run.frames == 10 and run.fps > 0 and run.cpu_ms_per_frame > 0


def test_the_codec_alone_has_the_threads_of_the_product(tmp_path, monkeypatch):
    threads_of = {}

    class Noted(offline_video.Decoder):
        def __init__(self, *args, threads, **options):
            super().__init__(*args, threads=threads, **options)
            threads_of["decoder"] = threads

    class NotedEncoder(encoding.VideoEncoder):
        def __init__(self, *args):
            super().__init__(*args)
            threads_of["encoder"] = self.threads

    monkeypatch.setattr(offline_video, "Decoder", Noted)
    monkeypatch.setattr(encoding, "VideoEncoder", NotedEncoder)
    source = write_video(tmp_path / "a.mkv", clip(10))
    runs.run_product(source, tmp_path / "out.mp4", LOOK)
    assert (threads_of["decoder"], threads_of["encoder"]) == harness.own_threads()


def test_empty_caches_lie_in_the_folder(tmp_path):
    variables = runs.empty_caches(tmp_path)
    assert set(variables) == {"POCL_CACHE_DIR", "XDG_CACHE_HOME"}
    assert all(folder.startswith(str(tmp_path)) for folder in variables.values())
