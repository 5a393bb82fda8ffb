"""`bench --live`: its arithmetic, and a real run of its processes. Nothing is timed."""

import json
import sys

import browser
import numpy as np
import pytest
from makeup_video.benchmark.live import COLUMNS, WARM_SECONDS, figures
from makeup_video.benchmark.tables import tables
from makeup_video.cli.app import app
from makeup_video.pipeline import OutputError
from people import SAMPLES, grey, write_video
from typer.testing import CliRunner

ARGS = ["bench", "--live", "--sizes", "144p", "--seconds", "0.5"]


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def table(seconds: float, late: float = 0.01) -> np.ndarray:
    """Frames that arrive 30 times a second; every stage takes a millisecond."""
    count = round(seconds * 30)
    came = 100 + np.arange(count) / 30
    frames = came[:, None] + np.linspace(0, late / 2, len(COLUMNS))
    frames[:, 0] = np.round(came * 1e6)
    return frames


def viewer_times(frames: np.ndarray, late: float = 0.01) -> np.ndarray:
    """The viewer needs 2 ms to decode a picture of 20 kB."""
    rows = [(pts, pts / 1e6 + late, pts / 1e6 + late + 0.002, 20_000) for pts in frames[:, 0]]
    return np.array([*rows, (0, 0.6, 0, 0)])


def samples(seconds: float) -> np.ndarray:
    seconds_in = np.arange(0, seconds + 1, 0.5)
    return np.column_stack([100 + seconds_in, 200 + seconds_in, 0.3 * seconds_in])


def test_latency_runs_from_arrival_to_viewer_after_warm_up():
    frames = table(30)
    viewed = viewer_times(frames)
    viewed[: round(WARM_SECONDS * 30), 1] += 5
    got = figures(frames, samples(30), viewed)
    assert got["frames"] == round((30 - WARM_SECONDS) * 30)
    for part in ("latency_ms", "first_seconds_latency_ms", "last_seconds_latency_ms"):
        assert got[part]["p50"] == pytest.approx(10, abs=0.01)
        assert got[part]["max"] == pytest.approx(10, abs=0.01)
    assert got["decoded_latency_ms"]["p50"] == pytest.approx(12, abs=0.01)
    assert got["bytes_per_picture"] == 20_000
    assert got["fps"] == pytest.approx(30, abs=0.01)
    assert got["dropped"] == got["dropped_before_painting"] == got["dropped_in_preview"] == 0
    assert got["cpu_cores"] == pytest.approx(0.3)
    assert got["cpu_ms_per_frame"] == pytest.approx(10, rel=0.01)
    assert got["memory_mb"]["after_10_s"] == pytest.approx(200 + WARM_SECONDS + 10, abs=0.01)
    assert got["viewer_cpu_ms_per_frame"] == pytest.approx(600 / 900)


def test_a_delay_that_grows_shows_at_the_end():
    frames = table(60)
    viewed = viewer_times(frames)
    viewed[:-1, 1] += np.arange(len(frames)) / len(frames) / 10
    got = figures(frames, samples(60), viewed)
    first, last = got["first_seconds_latency_ms"]["p50"], got["last_seconds_latency_ms"]["p50"]
    assert last - first > 70


def test_lost_frames_are_counted_where_they_were_lost():
    frames = table(20)
    frames[100:103, 2:] = np.nan  # a newer frame arrived while another was painted
    viewed = viewer_times(frames)
    viewed = np.delete(viewed, [100, 101, 102, 300, 301, 400], axis=0)
    frames = np.delete(frames, 400, axis=0)  # the camera itself was late
    got = figures(frames, samples(20), viewed)
    assert (got["dropped_before_painting"], got["dropped_in_preview"]) == (3, 2)
    assert got["dropped_by_camera"] == 1 and got["dropped"] == 6
    assert got["latency_ms"]["max"] == pytest.approx(10, abs=0.01)


def test_memory_that_the_system_does_not_report_is_unknown():
    memory = samples(10)
    memory[:, 1] = np.nan
    got = figures(table(10), memory, viewer_times(table(10)))
    assert got["memory_mb"] == {"after_10_s": None, "at_end": None}


def test_the_steps_of_a_frame_are_listed_in_order():
    got = figures(table(10), samples(10), viewer_times(table(10)))
    ways = list(got["ways_ms"])
    assert ways[0] == "arrival to work" and ways[-1] == "to the viewer"
    assert all(spread["p50"] >= 0 for spread in got["ways_ms"].values())


@pytest.fixture(scope="module")
def done():
    done = run(*ARGS, SAMPLES / "in.mp4", "--json")
    assert done.exit_code == 0, done.output
    return done


@pytest.fixture(scope="module")
def results(done):
    return json.loads(done.stdout)


def test_the_video_of_a_size_is_made_once(done):
    assert done.stderr.count("144p: making the video") == 1
    assert done.stderr.count("s live") == 2  # JPEG and H.264


def test_a_real_run_reports_every_figure(results):
    sizes = results["live"]["sizes"]
    live, as_h264 = sizes["144p"], sizes["144p, H.264"]
    assert set(live["latency_ms"]) >= {"p50", "p95", "p99"}
    assert 0 < live["latency_ms"]["p50"] <= live["latency_ms"]["p99"]
    assert live["frames"] > 0 and live["painted_share"] >= 0.95
    parts = "dropped_by_camera", "dropped_before_painting", "dropped_in_preview"
    assert live["dropped"] == sum(live[part] for part in parts)
    assert list(results["live"]) == ["sizes"] and list(sizes) == ["144p", "144p, H.264"]
    assert 0 < as_h264["bytes_per_picture"] < live["bytes_per_picture"] / 2
    for one in (live, as_h264):
        assert one["decoded_latency_ms"]["p50"] > one["latency_ms"]["p50"]
    for way in ("faces", "smooth", "scene", "composite", "preview", "to the viewer"):
        assert live["ways_ms"][way]["p50"] > 0


def test_results_are_printed_as_tables(results):
    (title, head, rows), (_, ways_head, ways), _ = tables(results)
    assert "live" in title and head == ("", "144p", "144p, H.264")
    assert all(len(row) == len(head) for row in rows)
    assert ways and all(len(row) == len(ways_head) for row in ways)


def test_the_page_in_chromium_tells_when_it_has_drawn():
    browser.executable()
    seconds = 4  # Chromium may take a second to draw its first picture
    done = run(*ARGS, "--seconds", seconds, "--chromium", SAMPLES / "in.mp4", "--json")
    assert done.exit_code == 0, done.output
    sizes = json.loads(done.stdout)["live"]["sizes"]
    assert list(sizes) == ["144p", "144p, H.264", "144p, Chromium", "144p, H.264, Chromium"]
    for one in list(sizes.values())[2:]:
        assert one["decoded_latency_ms"]["p50"] > one["latency_ms"]["p50"] > 0
        assert one["viewer_cpu_ms_per_frame"] > 0
    in_chromium = sizes["144p, H.264, Chromium"]["bytes_per_picture"]
    assert 0 < in_chromium < sizes["144p, Chromium"]["bytes_per_picture"] / 2


def test_a_viewer_that_saw_nothing_is_an_error_of_one_line():
    frames = table(3)
    for viewed in (viewer_times(frames)[:3], viewer_times(frames)[-1:]):
        with pytest.raises(OutputError, match=r"none of 60 pictures.*seconds=20"):
            figures(frames, samples(3), viewed)


def test_chromium_belongs_to_live_and_needs_playwright(monkeypatch):
    done = run("bench", "--chromium")
    assert done.exit_code == 2 and "--chromium needs --live" in done.output
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)  # as if it were not installed
    done = run(*ARGS, "--chromium")
    assert done.exit_code == 1 and "pip install playwright" in done.output


def test_live_refuses_other_measurements_beside_it(tmp_path):
    for more in (["--faces"], ["--threads"], ["--plot", tmp_path / "x.png"]):
        done = run(*ARGS, *more)
        assert done.exit_code == 2 and "--live" in done.output


def test_a_video_without_a_face_is_refused(tmp_path):
    done = run(*ARGS, write_video(tmp_path / "grey.mkv", [grey()] * 20))
    assert done.exit_code == 3 and "no face" in done.output
