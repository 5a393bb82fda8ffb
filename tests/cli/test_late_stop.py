"""A stop signal near the end of a run: the exit code, the last line and the files agree."""

import subprocess
import sys
from pathlib import Path

import pytest
from media import decoded, make_clip
from people import SAMPLES

# The real command. It receives a signal before or after it calls `name` of the module or class
# `where`.
HOOKED = """
import importlib, os, signal, sys, time
from makeup_video.cli import main
from makeup_video.pipeline.offline import looks_on_picture

looks_on_picture.cores = lambda: 1  # several looks of a picture are painted one after another
where, name, moment, number = sys.argv[1:5]
owner = importlib.import_module(where.split(":")[0])
if ":" in where:
    owner = getattr(owner, where.split(":")[1])
original = getattr(owner, name)

def stop():
    os.kill(os.getpid(), getattr(signal, number))
    time.sleep(0.5)

def hooked(*words, **more):
    open("hooked", "w").close()  # proves that the hook was called
    if moment == "before":
        stop()
    done = original(*words, **more)
    if moment == "after":
        stop()
    return done

setattr(owner, name, hooked)
sys.argv[1:] = sys.argv[5:]
main.main()
"""
MUXER = "makeup_video.pipeline.media.mux:Muxer"
PART = "makeup_video.pipeline.files.part_file:PartFile"  # renames the output and each side file


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make_clip(tmp_path / "in.mp4", audio="aac")
    return tmp_path


def run_hooked(where, name, moment, number, *words):
    command = [sys.executable, "-c", HOOKED, where, name, moment, number, *words]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=120)
    Path("hooked").unlink()
    return done.returncode, done.stderr.splitlines()


VIDEO = ("in.mp4", "--look", "none", "-o", "out.mp4", "--report", "r.json", "--save-look", "l.json")


@pytest.mark.parametrize(
    ("where", "name", "moment", "number"),
    [
        (MUXER, "finish", "before", "SIGINT"),
        (PART, "rename", "before", "SIGTERM"),
        (PART, "rename", "after", "SIGINT"),
        (MUXER, "finish", "after", "SIGTERM"),
        ("makeup_video.pipeline.offline.video", "video_report", "after", "SIGINT"),
    ],
)
def test_a_whole_output_ends_with_0_and_all_its_files(folder, where, name, moment, number):
    code, lines = run_hooked(where, name, moment, number, *VIDEO)
    assert (code, len(lines)) == (0, 1) and lines[0].startswith("out.mp4: 12 frames in")
    assert sorted(path.name for path in folder.iterdir()) == [
        "in.mp4",
        "l.json",
        "out.mp4",
        "r.json",
    ]
    assert len(decoded(folder / "out.mp4")) == 12


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_an_unfinished_output_ends_with_130_and_no_sidecars(folder, number):
    encoder = "makeup_video.pipeline.media.encode:VideoEncoder"
    code, lines = run_hooked(encoder, "__call__", "after", number, *VIDEO)
    assert (code, lines) == (130, ["stopped; out.part.mp4 holds what was done"])
    assert sorted(path.name for path in folder.iterdir()) == ["in.mp4", "out.part.mp4"]


@pytest.mark.parametrize("moment", ["before", "after"])
def test_a_stopped_picture_is_whole_or_absent(folder, moment):
    words = (str(SAMPLES / "look.jpg"), "--look", "none", "-o", "out.png", "--report", "r.json")
    code, lines = run_hooked(PART, "rename", moment, "SIGINT", *words)
    assert (code, lines[0].split(":")[0]) == (0, "out.png")
    still = "makeup_video.pipeline.offline.picture"
    code, lines = run_hooked(still, "encode_picture", moment, "SIGINT", *words, "-y")
    assert (code, lines) == (130, ["stopped"])
    assert sorted(path.name for path in folder.iterdir()) == ["in.mp4", "out.png", "r.json"]


def test_a_stop_between_the_looks_of_a_picture_ends_the_run(folder):
    many = [word for look in ("berry", "cat-eye", "glam") for word in ("--look", look)]
    words = (str(SAMPLES / "look.jpg"), *many, "-o", "{look}.png")
    code, lines = run_hooked(PART, "rename", "after", "SIGTERM", *words)
    assert code == 130 and lines[-1].startswith("stopped")
    assert 1 <= len(list(folder.glob("*.png"))) < 3


def test_points_of_a_whole_drawing_get_their_final_name(folder):
    words = ("inspect", "in.mp4", "-o", "seen.mp4", "--json", "p.json")
    code, lines = run_hooked(PART, "rename", "after", "SIGINT", *words)
    assert code == 0 and lines[-1].startswith("seen.mp4: ")
    assert sorted(path.name for path in folder.iterdir()) == ["in.mp4", "p.json", "seen.mp4"]
