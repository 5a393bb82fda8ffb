"""`makeup-video doctor` and `devices`: what this machine has, and what is wrong in one line each."""

import json

import pytest
from command_line import run
from makeup_video.benchmark.self_test import self_test
from makeup_video.cli import findings as findings_module
from makeup_video.cli.findings import NOTE, OK
from makeup_video.pipeline.engine import machine
from makeup_video.pipeline.live.sources import microphone
from makeup_video.pipeline.media.codecs import CODECS


@pytest.mark.timeout(300)
def test_a_sound_machine_has_a_line_for_everything():
    done = run("doctor", "--json")
    findings = {one["what"]: one for one in json.loads(done.stdout)}
    assert list(findings) == [
        "makeup-video", "system", "packages", "memory", "OpenCL", "encoders", "HEIC photos",
        "cameras", "self-test",
    ]  # fmt: skip
    assert done.exit_code == 0, done.stdout
    assert "av 1" in findings["packages"]["words"] and "h264" in findings["encoders"]["words"]
    assert "composite" in findings["self-test"]["words"]


@pytest.mark.parametrize(("count", "words"), [(1, ", 1 core"), (2, ", 2 cores")])
def test_cores_are_counted_in_words(monkeypatch, count, words):
    monkeypatch.setattr(machine, "cores", lambda: count)
    assert findings_module._system().endswith(words)


def test_what_is_wrong_is_one_line_and_an_exit_code():
    done = run("doctor", "--device", "no such device")
    lines = done.stdout.splitlines()
    assert done.exit_code == 1
    assert all(line[:4] in ("ok  ", "note", "bad ") for line in lines)
    wrong = [line for line in lines if line.startswith("bad")]
    assert len(wrong) == 1 and "self-test: UsageError: --device: an OpenCL device is" in wrong[0]


def test_a_folder_for_kernels_that_goes_away_is_noted(monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    assert findings_module._opencl().state == OK
    (tmp_path / "file").touch()
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "file"))
    noted = findings_module._opencl()
    assert noted.state == NOTE and noted.words.startswith("0 ")
    assert noted.words.endswith(": set POCL_CACHE_DIR to a folder that stays")


def test_a_self_test_paints_every_frame():
    done = self_test(seconds=0)
    assert done.frames == 1 and done.painted == 2
    assert list(done.stages_ms) == ["faces", "smooth", "scene", "composite", "encode"]


def test_devices_are_listed_by_the_names_that_options_take():
    found = json.loads(run("devices", "--json").stdout)
    assert list(found) == ["cameras", "microphones", "opencl", "encoders", "hardware"]
    assert set(found["encoders"]) == set(CODECS)
    assert "0" in found["opencl"]
    text = run("devices").stdout
    for rows in found.values():
        for name, words in rows.items():
            assert f"  {name}" in text and words in text


def test_microphones_of_alsa_are_named_as_ffmpeg_opens_them(tmp_path, monkeypatch):
    listed = tmp_path / "pcm"
    monkeypatch.setattr(microphone.sys, "platform", "linux")
    monkeypatch.setattr(microphone, "_ALSA_DEVICES", listed)
    assert microphone.microphones_found() == []
    listed.write_text(
        "00-00: HDA Analog : HDA Analog : playback 1\n01-02: USB Audio : USB Audio : capture 1\n"
    )
    assert microphone.microphones_found()[1:] == [("plughw:1,2", "USB Audio")]


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("makeup-video b", {"batch", "bench"}),
        ("makeup-video in.mp4 --stre", {"--strength"}),
        ("makeup-video --ref", {"--ref", "--ref-face"}),
        ("makeup-video in.mp4 --look smoky", {"smoky-black", "smoky-brown"}),
        ("makeup-video live --look cat", {"cat-eye"}),
    ],
)
def test_a_shell_completes_commands_options_and_looks(line, wanted, monkeypatch):
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(line.split()) - 1))
    monkeypatch.setenv("_MAKEUP_VIDEO_COMPLETE", "complete_bash")
    assert set(run().stdout.split()) == wanted


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--codec", "H.265", "--preset", "Very Fast"], "none.mp4 does not exist"),
        (["--faces", "Biggest", "--start", "1m 5s"], "none.mp4 does not exist"),
        (["--strength", "80%", "--finish", "Glossy", "--lips", "dark red:matt"], "none.mp4 does"),
        (["--faces", "left"], "--faces must be all, largest"),
    ],
)
def test_options_understand_what_people_type(options, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    look = [] if "--lips" in options else ["--look", "cat-eye"]
    done = run("none.mp4", *look, "-o", "out.mp4", *options)
    assert words in done.output
