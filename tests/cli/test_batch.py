"""`batch` from the command line: what is left out, what is refused, and what survives a kill."""

import json
import random
import shutil
import signal
import sys
import time
from collections import Counter

import av
import pytest
from command_line import LOOK, command, run
from media import make_clip
from people import SAMPLES, clip, write_video
from workers import run_here


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """A folder with two videos, of 320 x 180 px."""
    folder = tmp_path_factory.mktemp("videos")
    for name in ("a", "b"):
        write_video(folder / f"{name}.mkv", [picture[::2, ::2] for picture in clip(20)])
    return folder


@pytest.fixture
def folder(clips, tmp_path, monkeypatch):
    """Two videos and a look file, in the current folder."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(clips, tmp_path / "clips")
    (tmp_path / "red.json").write_text(json.dumps(LOOK))
    return tmp_path


@pytest.fixture
def slow_folder(folder):
    """The same folder with larger videos, which take longer."""
    for name in ("a", "b"):
        write_video(folder / "clips" / f"{name}.mkv", clip(20))
    return folder


def outputs_of(folder):
    return sorted(path.name for path in folder.iterdir())


def frames_in(path):
    with av.open(str(path)) as box:
        return sum(1 for _ in box.decode(video=0))


LOOKS = ("--look", "red.json", "--look", "none", "--codec", "ffv1")


def test_a_folder_in_several_looks(folder):
    shutil.copy(SAMPLES / "portrait.jpg", folder / "clips")
    done = run("batch", "clips", "--look", "red.json", "--look", "cat-eye",
               "-o", "out/{look}/{name}.{ext}")  # fmt: skip
    assert done.exit_code == 0, done.stderr
    assert outputs_of(folder / "out") == ["cat-eye", "index.html", "makeup-video.jsonl", "red"]
    assert outputs_of(folder / "out" / "red") == ["a.mkv", "b.mkv", "portrait.jpg"]
    assert "6 of 6 outputs done; out/index.html shows them" in done.stderr
    page = (folder / "out" / "index.html").read_text()
    assert page.count("<img") == 9  # for each input, one before and two after


def test_running_again_does_nothing_twice(folder):
    words = ("batch", "clips", *LOOKS, "-o", "clips/{name}-{look}.mkv")  # beside the inputs
    assert run_here(*words).exit_code == 0
    files = {path.name: path.stat() for path in (folder / "clips").glob("?-*.mkv")}
    assert len(files) == 4
    for more in ((), ("--resume",), ("-y",), ("--retry",)):
        again = run_here(*words, *more)
        assert again.exit_code == 0, again.stderr
        assert "4 of 4 outputs are in the journal already" in again.stderr
    now = {path.name: path.stat() for path in (folder / "clips").glob("?-*.mkv")}
    assert now == files


def test_a_bad_video_fails_alone_and_is_named_at_the_end(folder):
    (folder / "clips" / "bad.mp4").write_text("no video")
    words = ("batch", "clips", "--look", "none", "-o", "out/{name}.mp4")
    first = run(*words)
    assert first.exit_code == 5
    *_, listed, last = first.stderr.strip().splitlines()
    assert listed == "1 failed; --retry tries again:"
    assert last.startswith("  out/bad.mp4 failed: InputError: clips/bad.mp4 is not a video")
    assert frames_in(folder / "out" / "a.mp4") == frames_in(folder / "out" / "b.mp4") == 20
    again = run(*words)
    assert again.exit_code == 5 and last in again.stderr
    make_clip(folder / "clips" / "bad.mp4")
    assert run(*words).exit_code == 0  # a new file in place of the one that failed


def test_failed_work_is_done_again_on_request(folder):
    words = ("batch", "clips/a.mkv", "--look", "none", "--codec", "ffv1", "-o", "out/{name}.mkv")
    journal = folder / "out" / "makeup-video.jsonl"
    assert run_here(*words).exit_code == 0
    *lines, line = journal.read_text().splitlines()
    entry = json.loads(line)
    failed = {key: entry[key] for key in ("output", "key")}
    failed |= {"event": "failed", "kind": "OutputError", "error": "the disk is full"}
    journal.write_text("\n".join([*lines, json.dumps(failed)]) + "\n")
    (folder / "out" / "a.mkv").unlink()
    again = run_here(*words)
    assert again.exit_code == 5 and "OutputError: the disk is full" in again.stderr
    assert run_here(*words, "--retry").exit_code == 0
    assert frames_in(folder / "out" / "a.mkv") == 20


def test_the_journal_of_a_list_lies_above_all_outputs(folder):
    rows = ["clips/a.mkv,l/anna/{look}.mkv", "clips/b.mkv,l/ben/{look}.mkv"]
    for order in (rows, rows[::-1]):
        (folder / "jobs.csv").write_text("\n".join(["in,out", *order, ""]))
        done = run_here("batch", "--list", "jobs.csv", "--look", "none", "--codec", "ffv1")
        assert done.exit_code == 0, done.stderr
    assert "2 of 2 outputs are in the journal already" in done.stderr
    assert sorted(path.name for path in (folder / "l").iterdir()) == [
        "anna", "ben", "index.html", "makeup-video.jsonl",
    ]  # fmt: skip


def test_rows_with_one_output_are_both_named(folder):
    (folder / "jobs.csv").write_text("in,out\nclips/a.mkv,a.mkv\nclips/b.mkv,a.mkv\n")
    done = run_here("batch", "--list", "jobs.csv", "--look", "none")
    assert done.exit_code == 2
    assert "the name a.mkv (jobs.csv, line 2 and jobs.csv, line 3): give each" in done.stderr


@pytest.mark.parametrize(
    ("more", "template", "field"),
    [("b/a.mkv", "{name}.mkv", "{folder}"), ("clips/a.mov", "{name}.mkv", "{ext}"),
     ("clips/b.mkv", "{folder}.mkv", "{name}")],
)  # fmt: skip
def test_inputs_of_one_output_and_the_field_to_add_are_named(folder, more, template, field):
    (folder / more).parent.mkdir(exist_ok=True)
    (folder / more).touch()
    done = run_here("batch", "clips/a.mkv", more, "--look", "none", "-o", f"out/{template}")
    assert done.exit_code == 2
    assert f"(clips/a.mkv and {more}): give each its own, for example with {field}" in done.stderr


def test_a_link_and_a_lost_link_in_a_folder(folder):
    (folder / "clips" / "a-link.mkv").symlink_to("b.mkv")
    (folder / "clips" / "lost.mkv").symlink_to("gone.mkv")
    done = run_here("batch", "clips", "--look", "none", "--codec", "ffv1", "-o", "out/{name}.mkv")
    assert done.exit_code == 5 and "2 of 3 outputs done" in done.stderr
    assert sorted(path.name for path in (folder / "out").glob("*.mkv")) == ["a.mkv", "b.mkv"]
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith(
        "  out/lost.mkv failed: InputError: clips/lost.mkv is a link to gone.mkv"
    )


def test_a_look_of_a_row_leaves_the_face_of_the_photo_out(folder):
    (folder / "jobs.csv").write_text("in,look\nclips/a.mkv,none\n")
    done = run_here("batch", "--list", "jobs.csv", "--ref", str(SAMPLES / "look.jpg"), "--ref-face", "0",
               "--codec", "ffv1", "-o", "{name}-{look}.mkv")  # fmt: skip
    assert done.exit_code == 0, done.stderr


def test_a_row_chooses_the_face_of_its_own_photo(folder):
    (folder / "jobs.csv").write_text(f"in,ref,ref_face\nclips/a.mkv,{SAMPLES / 'look.jpg'},7\n")
    done = run_here("batch", "--list", "jobs.csv", "--look", "none", "-o", "{name}-{look}.mkv")
    assert done.exit_code == 3, done.stderr
    assert "jobs.csv, line 2: " in done.stderr and "there is no face 7 in the photo" in done.stderr


def test_outputs_that_a_shell_gives_as_inputs_are_left_out(folder):
    words = ("--look", "none", "--codec", "ffv1", "-o", "clips/{name}-{look}.mkv")
    for inputs in (["a", "b"], ["a", "a-none", "b", "b-none"]):
        done = run_here("batch", *(f"clips/{name}.mkv" for name in inputs), *words)
        assert done.exit_code == 0, done.stderr
    assert "2 of the files are outputs of this batch, and are not painted again" in done.stderr
    assert len(list((folder / "clips").glob("*.mkv"))) == 4


def test_a_list_gives_each_input_its_own_look(folder):
    (folder / "jobs.csv").write_text(
        "in,out,look,strength,end\nclips/a.mkv,,red.json,50%,0.2\nclips/b.mkv,x/{look}.mkv,,,\n"
    )
    done = run_here("batch", "--list", "jobs.csv", "--look", "none", "--codec", "ffv1",
               "-o", "out/{name}-{look}.mkv")  # fmt: skip
    assert done.exit_code == 0, done.stderr
    assert frames_in(folder / "out" / "a-red.mkv") == 6
    assert frames_in(folder / "x" / "none.mkv") == 20


def test_a_list_takes_the_words_for_faces_that_options_take(folder):
    (folder / "jobs.csv").write_text("in,out,faces,end\nclips/a.mkv,x.mkv,Biggest,0.2\n")
    done = run_here("batch", "--list", "jobs.csv", "--look", "none", "--codec", "ffv1")
    assert done.exit_code == 0, done.stderr
    assert frames_in(folder / "x.mkv") == 6


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["clips", *LOOKS, "-o", "out/{name}.mkv"],
         "2 looks need a name each: put {look} in -o, as in -o 'out/{name}-{look}.mkv'"),
        (["clips", "--look", "none", "-o", "out/all.mkv"], "two outputs have the name out/all.mkv"),
        (["clips", "--look", "none", "-o", "out/{nmae}.mkv"], "--output has {nmae}: the fields are"),
        (["clips", "--look", "none", "-o", "{folder}/{name}.mkv"], "would replace clips/a.mkv"),
        (["clips", "--look", "none"], "-o/--output is missing"),
        (["--look", "none", "-o", "out/{name}.mkv"], "no input given"),
        (["clips", "-o", "out/{name}.mkv"], "no look given"),
        (["clips", "--look", "none", "-o", "o/{name}.mkv", "--ship"], "--ship is for a cluster"),
        (["gone.mkv", "--look", "none", "-o", "o/{name}.mkv"], "gone.mkv does not exist: give files"),
        (["clips", "--look", "none", "-o", "out2/"], "that end in .mp4, .m4v, .mov, .mkv, .webm, .jpg,"),
        (["clips", "--look", "none", "-o", "o/{name}.avi"], "as in -o 'o/{name}.{ext}', got 'o/{name}.avi'"),
        (["clips/*.avi", "--look", "none", "-o", "{name}.mkv"], "clips/*.avi matches no file"),
        (["empty", "--look", "none", "-o", "{name}.mkv"], "empty has no videos or pictures"),
        (["clips", "--look", "none", "-o", "o/{name}.mkv", "--resume"], "there is no journal o/"),
        (["clips", "--look", "none", "-o", "o/{name}.mkv", "--jobs", "0"], "--jobs must be at least"),
        (["--list", "jobs.csv", "-o", "{name}.mkv"], "jobs.csv, line 2: there is no look file and"),
        (["clips", "--look", "none", "-o", "{name}.mkv", "--journal", "red.json"],
         "red.json, line 1, is no line of a batch's journal"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_said_in_one_line(folder, words, message):
    (folder / "empty").mkdir()
    (folder / "jobs.csv").write_text("in,look\nclips/a.mkv,nothing\n")
    done = run("batch", *words)
    assert done.exit_code == 2
    assert message in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not list(folder.glob("**/*.part.*")) and len(list(folder.glob("**/*.mkv"))) == 2


def test_without_ray_the_line_says_how_to_install_it(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "makeup_video.pipeline.batch.on_ray", None)
    monkeypatch.delattr("makeup_video.pipeline.batch.on_ray", raising=False)
    done = run("batch", "clips", "--look", "none", "-o", "o/{name}.mkv", "--ray", "auto")
    assert done.exit_code == 1
    assert done.stderr == "InstallError: --ray needs Ray: pip install 'makeup-video[ray]'\n"


def test_a_cluster_that_does_not_answer_is_named(folder):
    pytest.importorskip("ray", reason="needs makeup-video[ray]")
    words = ("batch", "clips", "--look", "none", "-o", "o/{name}.mkv", "--ray")
    for address in ("127.0.0.1:1", "auto"):
        done = run(*words, address)
        assert done.exit_code == 1 and len(done.stderr.strip().splitlines()) == 1
        assert done.stderr.startswith("WorkerError: --ray: no cluster")


def test_nothing_is_overwritten_without_y(folder):
    (folder / "out").mkdir()
    (folder / "out" / "b.mkv").write_text("mine")
    words = ("batch", "clips", "--look", "none", "--codec", "ffv1", "-o", "out/{name}.mkv")
    refused = run_here(*words)
    assert refused.exit_code == 2 and "out/b.mkv exists already: add -y" in refused.stderr
    assert (folder / "out" / "b.mkv").read_text() == "mine"
    assert not (folder / "out" / "a.mkv").exists()
    assert run_here(*words, "-y").exit_code == 0
    assert frames_in(folder / "out" / "b.mkv") == 20


@pytest.mark.parametrize("seed", range(2))
def test_a_batch_survives_being_killed_at_any_moment(slow_folder, seed):
    words = ("batch", "clips", *LOOKS, "-o", "out/{name}-{look}.mkv", "-q", "--jobs", "2")
    names = sorted(f"{video}-{look}.mkv" for video in "ab" for look in ("red", "none"))
    rng, seen = random.Random(seed), {}
    for attempt in range(5):
        process = command(*words)
        time.sleep(rng.uniform(0.5, 2 + attempt))
        process.send_signal(signal.SIGKILL)
        code = process.wait()
        for path in (slow_folder / "out").glob("?-*.mkv") if (slow_folder / "out").exists() else ():
            if ".part" not in path.name:  # a file with its final name is whole, and stays as it is
                assert frames_in(path) == 20
                assert seen.setdefault(path.name, path.stat().st_ino) == path.stat().st_ino
        if code == 0:
            break
    assert run_here(*words).exit_code == 0
    assert sorted(seen | {p.name: 0 for p in (slow_folder / "out").glob("?-*.mkv")}) == names
    assert not list(slow_folder.glob("**/*.part.*"))
    lines = [json.loads(line) for line in (slow_folder / "out" / "makeup-video.jsonl").open()]
    done = Counter(line["output"] for line in lines if line["event"] == "done")
    assert done == dict.fromkeys(names, 1)


def test_ctrl_c_ends_with_130_and_the_batch_goes_on_later(slow_folder):
    words = ("batch", "clips", *LOOKS, "-o", "out/{name}-{look}.mkv")
    process = command(*words)
    while not list(slow_folder.glob("out/*.part.mkv")):
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130
    assert errors.strip().splitlines()[-1] == "stopped: run the same command again to resume"
    assert not list(slow_folder.glob("**/*.part.*"))
    assert run_here(*words, "--resume").exit_code == 0
    assert len(list(slow_folder.glob("out/*.mkv"))) == 4


@pytest.mark.parametrize("template", ["{name}.mkv", "{name}-{look}.mkv", "{name}{name}/{look}.mkv"])
def test_a_name_that_grows_too_long_fails_alone(folder, template):
    """The name is too long with .part, with the name of the look, or as a folder."""
    shutil.copy(folder / "clips" / "a.mkv", folder / "clips" / f"{'x' * 248}.mkv")
    words = ("batch", "clips", "--look", "none", "--codec", "ffv1", "-o", f"out/{template}")
    for more in ((), (), ("--retry",)):
        done = run_here(*words, *more)
        assert done.exit_code == 5, done.stderr
        assert "2 of 3 outputs done" in done.stderr and "internal error" not in done.stderr
        last = done.stderr.strip().splitlines()[-1]
        assert "OutputError" in last and last.endswith("name too long; choose a shorter name")
    assert len(list((folder / "out").glob("**/*.mkv"))) == 2


def test_only_the_looks_whose_names_are_too_long_fail(folder):
    long = folder / f"{'x' * 240}.json"
    shutil.copy(folder / "red.json", long)
    done = run_here("batch", "clips", "--look", "none", "--look", long.name, "--codec", "ffv1",
               "-o", "out/{name}-to-be-seen-{look}.mkv")  # fmt: skip
    assert done.exit_code == 5 and "2 of 4 outputs done" in done.stderr
    assert len(list((folder / "out").glob("*.mkv"))) == 2
