"""`makeup-video bench` as a command: its options, output and errors. Nothing is timed."""

import io
import json
import sys
from pathlib import Path

import cv2
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.benchmark import plots, suite, video_costs
from makeup_video.benchmark.renderer import full_look
from makeup_video.cli import bench
from makeup_video.cli.app import app
from makeup_video.cli.console import ResultText
from makeup_video.pipeline import OutputError, UsageError
from people import SAMPLES, grey, write_video
from typer.testing import CliRunner

ARGS = [
    "bench", str(SAMPLES / "in.mp4"), "--sizes", "144p", "--seconds", "0.5", "--rounds", "1",
]  # fmt: skip


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    plot = tmp_path_factory.mktemp("bench") / "plot.png"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(video_costs, "_STARTS", 1)
        patch.setattr(video_costs, "BARE_THREADS", ((0, 0), (1, 2)))
        done = run(*ARGS, "--json", "--plot", plot)
    assert done.exit_code == 0, done.output
    assert plots.find_spec("matplotlib")
    assert cv2.imread(str(plot)).shape[1] > 600 and plot.stat().st_size < 60e3
    return json.loads(done.stdout)


def test_json_holds_every_number(results):
    assert list(results["sizes"]) == ["144p"]
    assert results["clip"] == "in.mp4" and len(results["look"]["layers"]) >= 2
    for row in results["sizes"].values():
        for kind in ("bare", "codec", "none", "product"):
            low, high = row[kind]["fps_spread"]
            assert 0 < low <= row[kind]["fps"] <= high and row[kind]["cpu_ms_per_frame"] > 0
        assert row["product"]["ratio"] > 0 and "not_codec_cpu_ms" in row["product"]
        assert row["painted_share"] >= 0.95 and row["default_times_real_time"] > 0
        assert row["start_seconds"] > 0 and row["first_start_seconds"] > 0
        assert row["peak_memory_mb"] > 20
        assert next(iter(row["stages"])) == "decode" and "composite" in row["stages"]
        assert set(row["channels"]) <= {f"-> {name}" for name in row["stages"]}
        assert row["bottleneck"] in row["stages"]
        floor = row["floor"]
        parts = floor["copy_ms"], floor["paint_ms"], floor["nets_ms"]
        assert min(parts) > 0 and floor["least_ms"] == pytest.approx(sum(parts))
        assert floor["decode_ms"] > 0 and row["renderer"]["composite_ms"] > 0


def test_every_number_is_printed_in_tables(results):
    from makeup_video.benchmark.tables import draw_tables, tables

    more = {
        "faces": {"height_px": 720, "further_face_cpu_ms": 2.5,
                  "counts": {"1": {"fps": 99.0, "ratio": 0.5, "not_codec_cpu_ms": 4.0}}},
        "threads": {"size": "720p", "best": "x",
                    "settings": {"x": {"fps": 9.0, "cpu_ms_per_frame": 8.0}}},
        "length": {"size": "360p", "minutes": 60.0, "fps": 150.0, "peak_memory_mb": 250.0,
                   "growth": 1.001, "memory": []},
    }  # fmt: skip
    found = list(tables(results | more))
    assert len(found) == 7
    for title, head, rows in found:
        assert title and rows and all(len(row) == len(head) for row in rows)
    drawn = ResultText()
    draw_tables(results | more, drawn)
    assert found[0][0][:40] in drawn.getvalue()
    text = str(found)
    for word in ("whole product / bare", "not codec", "measured / floor", "1.001", "composite"):
        assert word in text


@pytest.mark.parametrize(("encoding", "is_plain"), [("ascii", True), ("utf-8", False)])
def test_tables_have_the_boxes_of_stdouts_encoding(results, monkeypatch, encoding, is_plain):
    from makeup_video.benchmark.tables import draw_tables

    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding=encoding))
    drawn = ResultText()
    draw_tables(results, drawn)
    assert drawn.getvalue().isascii() == is_plain


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="writes to a device that is always full")
def test_tables_that_cannot_be_printed_are_one_line(results, monkeypatch):
    full = open("/dev/full", "w")  # noqa: SIM115
    monkeypatch.setattr(sys, "stdout", full)
    with pytest.raises(OutputError, match="stdout cannot be written: No space left"):
        bench._show(results, None, False)


def test_a_picture_is_no_clip_to_measure_with():
    done = run("bench", SAMPLES / "portrait.jpg")
    assert done.exit_code == 3 and "is a picture, and a benchmark needs a video" in done.output


@given(st.lists(st.integers(1, 2160).map(lambda half: 2 * half), min_size=1, max_size=4))
def test_sizes_are_read(heights):
    assert suite.heights_of(",".join(f"{h}p" for h in heights)) == heights
    assert suite.heights_of(",".join(str(h) for h in heights)) == heights


@pytest.mark.parametrize("sizes", ["", "p", "720p,", "0p", "721p", "9999p", "-2", "1e3", "²p", "x"])
def test_other_sizes_are_refused(sizes):
    with pytest.raises(UsageError, match="even heights such as 720p,1080p"):
        suite.heights_of(sizes)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--seconds", "0"), "--seconds must be 0.5"),
        (("--seconds", "nan"), "--seconds must be 0.5"),
        (("--rounds", "0"), "--rounds at least 1"),
        (("--length", "-1"), "--length must be"),
        (("--look", "a.json", "--ref", "b.jpg"), "leave one of them out"),
        (("--plot", "a.jpg"), "--plot must name a .png"),
        (("--plot", "/no/such/folder/a.png"), "there is no folder"),
        (("--look", "none.json"), "none.json"),
    ],
)
def test_wrong_options_are_one_line(args, message):
    done = run(*ARGS, *args)
    assert done.exit_code in (2, 4)
    assert message in done.stderr and "Traceback" not in done.output


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("no file", *ARGS[2:]), 3),
        ((*ARGS[1:], "--ref", "no file"), 3),
        ((*ARGS[1:], "--look", "a.json", "--ref", "b.jpg"), 2),
    ],
)
def test_inputs_are_checked_before_anything_is_logged(words, code):
    done = run("bench", *words)
    assert done.exit_code == code and len(done.stderr.splitlines()) == 1


def test_callers_in_python_read_the_names_of_python():
    with pytest.raises(UsageError, match=r"^minutes must be 0 to 600 minutes, got -1$"):
        suite.check_options(1, 1, suite.Extras(minutes=-1), live=False, plot=None)
    with pytest.raises(UsageError, match=r"^look and ref both give a look: "):
        suite.check_sources("a.json", "b.jpg")
    with pytest.raises(UsageError, match=r"^plot must name a \.png file, "):
        plots.check_plot_path("a.jpg")


def test_a_plot_without_matplotlib_is_refused_at_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setattr(plots, "find_spec", lambda name: None)
    done = run(*ARGS, "--plot", "a.png")
    assert done.exit_code != 0
    assert done.stderr.splitlines() == [
        "InstallError: --plot needs matplotlib: pip install 'makeup-video[plot]'"
    ]


def test_a_clip_without_faces_is_refused(tmp_path):
    clip = write_video(tmp_path / "grey.mkv", [grey(64, 48)] * 3)
    done = run("bench", clip, *ARGS[2:])
    assert done.exit_code == 3 and "no face to paint on" in done.stderr


def test_a_look_without_makeup_is_refused(tmp_path):
    look = tmp_path / "bare.json"
    look.write_text('{"version": 2, "layers": []}')
    done = run(*ARGS, "--look", look)
    assert done.exit_code == 2 and "paints nothing" in done.stderr


def test_without_our_samples_it_asks_for_a_clip(tmp_path, monkeypatch):
    monkeypatch.setattr(suite, "_SAMPLES", tmp_path)
    done = run("bench", *ARGS[2:])
    assert done.exit_code == 3 and "give a CLIP" in done.stderr
    look, photo = suite.sample_look(None, None)
    assert photo is None
    assert look == full_look() and not look.is_bare
