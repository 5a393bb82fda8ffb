"""Jobs on a Ray cluster of three nodes, all on this machine; needs Ray, which is an extra."""

import os
import signal
import socket
import threading
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from makeup_video.pipeline import (
    InputError,
    Look,
    Settings,
    StoppedError,
    UsageError,
    WorkerError,
    process_video,
    product,
)
from makeup_video.pipeline.batch.job import Done, Job, JobLook
from makeup_video.pipeline.batch.journal import Journal
from makeup_video.pipeline.batch.run import run_batch
from makeup_video.pipeline.batch.task import do_job
from media import decoded, make_clip
from people import clip, write_video

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
cluster_utils = pytest.importorskip("ray.cluster_utils", reason="needs makeup-video[ray]")
from makeup_video.pipeline.batch import on_ray  # imports Ray

BERRY = Look(lips=product((120, 10, 60), "satin"))
pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def nodes():
    """A cluster of three nodes with one CPU each; the first is the head and takes no jobs."""
    node = {"object_store_memory": 100_000_000}
    made = cluster_utils.Cluster(
        initialize_head=True, head_node_args={**node, "num_cpus": 0, "include_dashboard": False}
    )
    for _ in range(2):
        made.add_node(**node, num_cpus=1)
    yield made
    made.shutdown()


class Heard:
    def __init__(self, on_progress=lambda progress: None):
        self.seen, self._on_progress = [], on_progress

    def progress(self, job, progress):
        self.seen.append(progress)
        self._on_progress(progress)

    def ended(self, job, results):
        pass


def job_of(source, *names, look=BERRY, **settings):
    looks = (JobLook(name, look, str(source.with_name(f"{source.stem}-{name}{source.suffix}")))
             for name in names)  # fmt: skip
    return Job(str(source), tuple(looks), Settings(**settings))


def run(nodes, folder, jobs, heard=None, **how):
    with on_ray.cluster(nodes.address), Journal(folder / "j.jsonl") as journal:
        return run_batch(jobs, journal, heard or Heard(), on_ray.ray_workers(**how))


@pytest.mark.parametrize("ship", [False, True])
def test_jobs_are_done_and_a_bad_one_fails_alone(nodes, tmp_path, ship, monkeypatch):
    monkeypatch.chdir(tmp_path)  # outputs are named relative to this folder
    good, bad = write_video(tmp_path / "good.mkv", clip(12)), tmp_path / "bad.mkv"
    bad.write_text("no video")
    jobs = [job_of(path.relative_to(tmp_path), "a", "b", codec="ffv1") for path in (good, bad)]
    heard = Heard()
    results = run(nodes, tmp_path, jobs, heard, ship=ship)
    for name in ("a", "b"):
        done, failed = results[f"good-{name}.mkv"], results[f"bad-{name}.mkv"]
        assert (done.frames, done.size) == (12, os.stat(f"good-{name}.mkv").st_size)
        assert done.after and isinstance(failed.error, InputError)
        assert os.path.basename(str(bad)) in str(failed.error)
        assert "makeup-video-" not in str(failed.error)  # the temporary folder of a worker
    assert {one.looks for one in heard.seen} <= {("a", "b")}
    assert not list(tmp_path.glob("*.part.*"))


@pytest.mark.parametrize("ship", [False, True])
def test_a_job_whose_process_is_killed_is_done_again(nodes, tmp_path, ship):
    job = job_of(write_video(tmp_path / "in.mkv", clip(40)), "a", codec="ffv1")
    killed = []

    def kill(progress):
        if not killed and progress.frames:
            killed.append(_kill_painter())

    results = run(nodes, tmp_path, [job], Heard(kill), ship=ship, count=1)
    (result,) = results.values()
    assert killed and isinstance(result, Done) and result.frames == 40
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in-a.mkv", "in.mkv", "j.jsonl"]


def _kill_painter():
    """Kill the process that runs the task, as the kernel does when memory runs out."""
    for entry in os.scandir("/proc"):
        try:
            words = open(f"/proc/{entry.name}/cmdline", "rb").read()  # noqa: SIM115
        except (OSError, NotADirectoryError):
            continue
        if b"ray::_on_machine" in words:
            os.kill(int(entry.name), signal.SIGKILL)
            return int(entry.name)
    raise AssertionError("no task runs")


def test_a_node_that_is_lost_gives_its_job_to_another(nodes, tmp_path):
    jobs = [
        job_of(write_video(tmp_path / f"{name}.mkv", clip(40)), "x", codec="ffv1") for name in "ab"
    ]
    lost = nodes.add_node(num_cpus=1, object_store_memory=100_000_000)
    removed = []

    def remove(progress):
        if not removed and progress.frames:
            removed.append(lost)
            nodes.remove_node(lost, allow_graceful=False)

    results = run(nodes, tmp_path, jobs, Heard(remove))
    assert removed and all(isinstance(one, Done) for one in results.values())
    assert not list(tmp_path.glob("*.part.*"))


def test_an_output_finished_before_the_loss_is_not_made_again(tmp_path):
    source = make_clip(tmp_path / "in.mp4")
    job = replace(job_of(source, "a", "b", look=Look()), was=(None, None))
    do_job(job.only(set(job.outputs[:1])), lambda progress: None)
    before = os.stat(job.outputs[0])
    results = do_job(job.again(), lambda progress: None)
    assert [one.frames for one in results] == [12, 12]
    assert os.stat(job.outputs[0]).st_mtime_ns == before.st_mtime_ns


class StopsWorker:
    """Stands in for both the task and the shipped files, and stops the worker when it is used."""

    def __init__(self):
        self.begun, self.cancelled = [], []

    def pieces_of(self, path, check):
        self.stop()
        check()
        pytest.fail("it reads on")

    def options(self, **_):
        return self

    def remote(self, *_):
        self.stop()
        self.begun.append(self)
        return self

    def cancel(self, task, force):
        self.cancelled.append(task)

    def __iter__(self):
        raise on_ray.RayError("cancelled" if self.cancelled else "it goes on")


@pytest.mark.parametrize("ship", [False, True])
def test_a_stop_while_a_job_is_submitted_is_heard(tmp_path, monkeypatch, ship):
    double = StopsWorker()
    worker = on_ray.RayWorker(1, double if ship else None)
    double.stop = worker.stop
    monkeypatch.setattr(on_ray, "_TASK", double)
    monkeypatch.setattr(on_ray.ray, "cancel", double.cancel)
    with pytest.raises(StoppedError):
        worker.run(do_job, job_of(tmp_path / "in.mkv", "a"), lambda progress: None)
    assert len(double.begun) == len(double.cancelled) == (0 if ship else 1)


@pytest.mark.parametrize(
    ("address", "error", "message"),
    [
        ("127.0.0.1:1", WorkerError, "no cluster answers at 127.0.0.1:1"),
        ("nobody.invalid:6379", WorkerError, "no cluster answers at nobody.invalid:6379"),
        ("here", UsageError, "must be auto or HOST:PORT, got 'here'"),
    ],
)
@pytest.mark.timeout(60)  # Ray alone tries for minutes
def test_a_cluster_that_does_not_answer_is_named_soon(address, error, message):
    with pytest.raises(error, match=message), on_ray.cluster(address):
        pass


def test_a_connection_that_is_there_is_used_and_stays(nodes):
    with on_ray.cluster(nodes.address):
        with on_ray.cluster("auto"):
            assert on_ray.ray_workers()
        assert on_ray.ray.is_initialized()
        with pytest.raises(UsageError, match="connected to a cluster already: give auto"):
            on_ray.cluster(nodes.address).__enter__()
    assert not on_ray.ray.is_initialized()


SETTINGS, UNKNOWN_CALL = b"\0\0\0\4\0\0\0\0\0", b"\0\0\1\1\5\0\0\0\1\x88"


@pytest.mark.parametrize(
    "says", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n", SETTINGS, SETTINGS + UNKNOWN_CALL]
)
@pytest.mark.timeout(10)
def test_what_is_no_cluster_is_named_soon(says):
    with socket.create_server(("127.0.0.1", 0)) as server:
        kept = []

        def answer():
            kept.append(server.accept()[0])
            kept[0].sendall(says)

        threading.Thread(target=answer, daemon=True).start()
        address = f"127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(WorkerError, match=address), on_ray.cluster(address):
            pass
        kept[0].close()


@pytest.mark.parametrize("name", ["0", "1", "in", "out-0"])
def test_a_shipped_input_may_have_any_name(tmp_path, name):
    source = make_clip(tmp_path / "in.mp4").rename(tmp_path / name)
    (tmp_path / "there").mkdir()
    job = job_of(source, "a", "b", look=Look())
    here = on_ray.received(job, tmp_path / "there", [])
    paths = [os.path.dirname(path) for path in (here.source, *here.outputs)]
    assert len(set(paths)) == 3 and all(map(os.path.isdir, paths))
    assert os.path.isfile(here.source) and os.path.basename(here.source) == name


def test_an_input_that_is_gone_fails_alone(nodes, tmp_path):
    jobs = [job_of(tmp_path / "gone.mkv", "a"), job_of(make_clip(tmp_path / "in.mp4"), "a")]
    gone, done = run(nodes, tmp_path, jobs, ship=True).values()
    assert isinstance(gone.error, InputError) and isinstance(done, Done)


@pytest.mark.parametrize("ship", [False, True])
def test_segments_of_a_video_are_painted_on_the_cluster(nodes, tmp_path, ship):
    """One segment's worker is killed; the video equals the one that local processes make."""
    src = write_video(tmp_path / "in.mkv", clip(90))  # every frame is a key frame
    settings = Settings(codec="ffv1", split_minutes=Fraction(1, 60))
    killed, counts = [], []

    def tick(done, expected, rate):
        counts.append(done)
        if not killed and done:
            killed.append(_kill_painter())

    with on_ray.cluster(nodes.address):
        workers = on_ray.ray_workers(ship=ship)
        report = process_video(src, tmp_path / "ray.mkv", BERRY, settings, tick, workers)
    assert killed and report.segments == 3 and report.painted_frames == 90
    assert counts == sorted(counts) and counts[-1] == 90
    process_video(src, tmp_path / "here.mkv", BERRY, settings)
    for one, other in zip(decoded(tmp_path / "ray.mkv"), decoded(tmp_path / "here.mkv"),
                          strict=True):  # fmt: skip
        np.testing.assert_array_equal(one.to_ndarray(), other.to_ndarray())
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["here.mkv", "in.mkv", "ray.mkv"]


def test_at_least_one_worker_is_needed(nodes):
    with on_ray.cluster(nodes.address):
        assert len(on_ray.ray_workers()) >= 2
        assert len(on_ray.ray_workers(5)) == 5
        with pytest.raises(UsageError, match="must be at least 1, got 0"):
            on_ray.ray_workers(0)
