"""The fuzzer itself: cases are reproducible, and every kind of failure is found."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from fuzz import child, run
from fuzz.case import Case, make_case
from fuzz.child import Answer
from fuzz.mutate import GENERAL
from fuzz.mutate_photos import OWN as OWN_PHOTOS
from fuzz.mutate_texts import mutate_catalogue, mutate_look
from fuzz.mutate_videos import OWN as OWN_VIDEOS
from fuzz.play import IS_POSSIBLE, Limits, Result, play
from fuzz.seeds import KINDS, make, make_seeds

pytestmark = pytest.mark.skipif(not IS_POSSIBLE, reason="the fuzzer needs Linux")

ROOT = Path(__file__).parents[2]
CASE = Case(
    kind="video", seed="s", number=0, name="a.mp4", data=b"video", damage="", action="video",
    output="out.mkv",
)  # fmt: skip


@pytest.fixture(scope="module")
def seeds():
    return {kind: make_seeds(kind) for kind in KINDS}


def fuzz(*words):
    """Run `python -m tests.fuzz` in a new process, which has no threads from other tests."""
    command = [sys.executable, "-m", "tests.fuzz", "--jobs", "1", *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def played(monkeypatch, does, case=CASE, limits=None):
    """The verdict on a case in which the product does `does`."""
    monkeypatch.setattr(child, "run", does)
    return play(case, limits or Limits(seconds=20))


@pytest.mark.parametrize("kind", KINDS)
def test_a_handful_of_cases_of_each_kind_is_right(kind):
    done = fuzz("--kind", kind, "--count", "8", "--seed", "handful")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "8 cases in" in done.stdout and "0 of them wrong" in done.stdout


def test_whole_files_come_through_as_promised():
    done = fuzz("--kind", "video", "--as-is", "--count", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1  video: done" in done.stdout


def test_every_seed_can_be_made_here(seeds):
    assert [made.left_out for made in seeds.values()] == [{}, {}, {}]


def test_a_seed_that_cannot_be_made_is_left_out_by_name(tmp_path):
    def refuse(path):
        raise ValueError("no such encoder")

    made = make({"whole": lambda path: path.write_bytes(b"x"), "odd": refuse})
    assert made.files == {"whole": b"x"}
    assert made.left_out == {"odd": "ValueError: no such encoder"}


@pytest.mark.parametrize("kind", ["photo", "text"])  # no videos: a rare encoding differs by chance
def test_another_process_makes_the_same_cases(seeds, tmp_path, kind):
    words = ("--kind", kind, "--seed", "again", "--first", "3", "--count", "1")
    done = fuzz(*words, "--seconds", "0.001", "--keep", str(tmp_path))
    assert f"mark {seeds[kind].mark}" in done.stdout
    case = make_case(kind, "again", 3, seeds[kind])
    kept = tmp_path / f"{kind}_again_3"
    assert (kept / case.input).read_bytes() == case.data
    assert (kept / "how.txt").read_text().splitlines()[0] == case.command


@pytest.mark.parametrize("kind", KINDS)
def test_cases_follow_from_seed_and_number(seeds, kind):
    for number in range(40):
        assert make_case(kind, "7", number, seeds[kind]) == make_case(
            kind, "7", number, seeds[kind]
        )
    files = {make_case(kind, seed, n, seeds[kind]).data for seed in "78" for n in range(40)}
    assert len(files) > 60


@pytest.mark.parametrize(
    "data", [b"\0", b"ab", b"\xff\xd8\xff\xe0", b"II*\0", b"\x89PNG\r\n\x1a\n"]
)
def test_mutations_accept_any_remains_of_a_file(data):
    own = [mutation for some in (*OWN_VIDEOS.values(), *OWN_PHOTOS.values()) for mutation in some]
    for number in range(20):
        for mutation in (*GENERAL, *own):
            assert isinstance(mutation(Random(number), data), bytes)


def test_texts_are_damaged_in_every_way(seeds):
    files = seeds["text"].files
    kinds = {mutate_look(Random(n), files["both.json"])[1] for n in range(200)}
    assert len(kinds) == 8
    assert len({mutate_catalogue(Random(n), files["commas.csv"])[1] for n in range(200)}) == 12


def test_a_clean_refusal_has_no_faults(monkeypatch):
    result = played(monkeypatch, lambda _: Answer("refused InputError", "one line"))
    assert (result.outcome, result.faults) == ("refused InputError", [])


def test_a_crash_is_found(monkeypatch):
    result = played(monkeypatch, lambda _: os.kill(os.getpid(), signal.SIGSEGV))
    assert result.faults == ["ended by SIGSEGV"]


def test_a_process_that_ends_without_an_answer_is_found(monkeypatch):
    result = played(monkeypatch, lambda _: os._exit(0))
    assert result.faults == ["ended with exit code 0 and no answer"]


def test_a_hang_is_found_and_ended(monkeypatch):
    result = played(monkeypatch, lambda _: time.sleep(600), limits=Limits(seconds=0.2))
    assert result.faults == ["still at work after 0.2 s"]


def test_too_much_memory_is_found(monkeypatch):
    def waste(_):
        assert len(bytes(b"x" * 300_000_000)) > 0
        return Answer("refused InputError", "one line")

    (fault,) = played(monkeypatch, waste, limits=Limits(most_mb=250)).faults
    assert fault.endswith("MB of memory")


@pytest.mark.parametrize("error", [KeyError("x"), MemoryError(), SystemExit(3), ValueError("y")])
def test_errors_that_are_not_ours_are_found(monkeypatch, error):
    def fail(_):
        raise error

    monkeypatch.setitem(child._ACTIONS, "video", fail)
    (fault,) = play(CASE, Limits()).faults
    assert type(error).__name__ in fault


def test_an_error_of_two_lines_is_found(monkeypatch):
    from makeup_video.pipeline import InputError

    def fail(_):
        raise InputError("one\ntwo")

    monkeypatch.setitem(child._ACTIONS, "video", fail)
    (fault,) = play(CASE, Limits()).faults
    assert "not one line" in fault


@pytest.mark.parametrize("left", ["out.part.mkv", "out.mkv", "core"])
def test_what_an_error_leaves_behind_is_found(monkeypatch, left):
    def leave(_):
        Path(left).write_bytes(b"x")
        return Answer("refused DecodeError", "one line")

    assert played(monkeypatch, leave).faults == [f"left behind: {left}"]


@pytest.mark.parametrize(
    "change", [lambda path: path.unlink(), lambda path: path.write_bytes(b"f")]
)
def test_a_changed_input_is_found(monkeypatch, change):
    def spoil(_):
        change(Path(CASE.input))
        return Answer("refused InputError", "one line")

    assert "the input was changed" in played(monkeypatch, spoil).faults


def test_an_output_that_is_not_there_is_found(monkeypatch):
    assert played(monkeypatch, lambda _: Answer("done")).faults == ["not there: out.mkv"]


def test_an_old_output_must_survive_errors_and_only_errors(monkeypatch):
    case = replace(CASE, has_old=True)
    assert played(monkeypatch, lambda _: Answer("refused InputError", "x"), case).faults == []
    assert played(monkeypatch, lambda _: Answer("done"), case).faults == [
        "the old output is still there"
    ]

    def spoil(_):
        Path("out.mkv").write_bytes(b"half")
        return Answer("refused InputError", "x")

    assert played(monkeypatch, spoil, case).faults == ["the old output was changed"]


@pytest.mark.parametrize(
    ("code", "stderr", "fault"),
    [
        (3, "InputError: no\n", None),
        (3, "", "exit code 3 with 0 lines of ours"),
        (3, "InputError: no\nInputError: no\n", "exit code 3 with 2 lines of ours"),
        (1, "internal error: KeyError\n", "exit code 1: internal error: KeyError"),
        (3, "libx: oh\nInputError: no\n", "printed beside our lines: libx: oh"),
    ],
)
def test_the_output_of_a_command_is_judged(monkeypatch, code, stderr, fault):
    def command(_):
        sys.stderr.flush()
        os.write(2, stderr.encode())
        os._exit(code)

    monkeypatch.setattr(child, "run_command", command)
    faults = play(replace(CASE, by_command=True), Limits()).faults
    assert faults == [] if fault is None else faults[0].startswith(fault)


def test_a_fault_is_printed_with_the_command_to_repeat_it(capsys):
    job = run.Job("photo", "5", 17, False, Limits(), None)
    tally = run.Tally()
    tally.take(job, {"name": "a.jpg", "damage": "cut", "command": "c"}, Result("done", "", ["bad"]))
    assert tally.wrong == 1
    output = capsys.readouterr().out
    assert "bad" in output
    assert "python -m tests.fuzz --kind photo --seed 5 --first 17 --count 1" in output


def test_the_exit_code_is_1_when_a_case_is_wrong():
    done = fuzz("--kind", "text", "--count", "2", "--most-mb", "1")
    assert done.returncode == 1
    assert "2 of them wrong" in done.stdout
