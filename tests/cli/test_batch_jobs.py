"""The inputs of `batch`: pictures and videos in one folder, what is left out, what is missing."""

import shutil

import av
import pytest
from command_line import run
from media import damage, make_clip
from picture_files import scene, write
from workers import run_here

ADVICE = "a template that ends in .{ext}, as in -o '{name}.{ext}', suits pictures and videos"
WORDS = ("--look", "none", "-o")


@pytest.fixture
def mixed(tmp_path, monkeypatch):
    """A folder with a picture and two videos. AVI can be read, but not written."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    make_clip(tmp_path / "in" / "a.avi", "mpeg4")
    make_clip(tmp_path / "in" / "b.mp4")
    write(tmp_path / "in" / "c.png", scene())
    return tmp_path


def frames_in(path):
    with av.open(str(path)) as box:
        return sum(1 for _ in box.decode(video=0))


def test_one_template_names_pictures_and_videos(mixed):
    done = run_here("batch", "in", *WORDS, "out/{name}.{ext}")
    assert done.exit_code == 0, done.stderr
    assert sorted(path.name for path in (mixed / "out").glob("?.*")) == ["a.mp4", "b.mp4", "c.png"]


def test_pictures_beside_videos_take_no_options_of_videos(mixed):
    words = (*WORDS, "o/{name}.{ext}", "--end", "0.2", "--crf", "30")
    done = run_here("batch", "in", *words)
    assert done.exit_code == 0, done.stderr
    assert "1 picture is painted without --crf and --end: for videos only" in done.stderr
    assert frames_in(mixed / "o" / "b.mp4") < frames_in(mixed / "in" / "b.mp4")
    again = run_here("batch", "in", *WORDS, "o/{name}.{ext}", "--end", "0.2", "--crf", "31", "-y")
    assert "1 of 3 outputs are in the journal already" in again.stderr  # the picture
    alone = run_here("batch", "in/c.png", *WORDS, "p/{name}.{ext}", "--end", "0.2")
    assert alone.exit_code == 5
    assert "is a picture: leave out --end (for videos only)" in alone.stderr


def test_a_mistyped_folder_is_named_in_a_batch_that_goes_on(mixed):
    words = (*WORDS, "o/{name}.{ext}")
    assert run_here("batch", "in", *words).exit_code == 0
    page = (mixed / "o" / "index.html").read_bytes()
    again = run_here("batch", "inn", *words)
    assert again.exit_code == 2 and "inn does not exist: give files, a folder" in again.stderr
    assert (mixed / "o" / "index.html").read_bytes() == page


def test_a_picture_named_as_a_video_is_told_of_the_field(mixed):
    words = ("batch", "in", *WORDS, "out/{name}.mp4")
    for more in ([], ["--retry"]):
        done = run_here(*words, *more)
        head, line, last = done.stderr.strip().splitlines()[-3:]
        assert done.exit_code == 5 and last == ADVICE
        assert head == "1 failed, and would fail again with --retry:"
        assert "in/c.png is a picture: the output must end in .jpg" in line


def test_retry_is_advised_where_it_may_help(mixed):
    words = ("batch", "in", *WORDS, "out/{name}.{ext}")
    (mixed / "in" / "d.mp4").write_text("no video")
    assert run_here(*words).exit_code == 5
    with (mixed / "out" / "b.mp4").open("ab") as file:
        file.write(b"x")
    *_, first, bad, second, changed = run_here(*words).stderr.strip().splitlines()
    assert first == "1 failed; --retry tries again:" and "d.mp4 is not a video" in bad
    assert second == "1 failed, and would fail again with --retry:"
    assert "out/b.mp4 has changed since" in changed and "add -y to write it again" in changed
    assert run_here(*words, "-y").stderr.count("--retry") == 1


def test_pictures_that_are_not_painted_are_named(mixed):
    for name in ("p.avif", "p.tif", "p.bmp", "note.txt", ".p.tif"):
        (mixed / "in" / name).touch()
    for quiet in ([], ["-q"]):
        done = run_here("batch", "in", *WORDS, "out/{name}.{ext}", *quiet)
        assert done.exit_code == 0, done.stderr
        line = "3 files left out: p.avif, p.bmp and p.tif (AVIF, BMP and TIFF pictures are not"
        assert (line in done.stderr) == (not quiet)
    shutil.copy(mixed / "in" / "b.mp4", "z.mp4")
    assert "left out" not in run_here("batch", "z.mp4", *WORDS, "out/{name}.{ext}").stderr


@pytest.mark.parametrize(
    ("inputs", "code", "message"),
    [
        (["nodir"], 2, "nodir does not exist: give files, a folder"),
        (["--list", "jobs.csv"], 2, "jobs.csv, line 2: gone.mp4 does not exist: give files"),
        ([""], 3, "the name of the video or picture is empty: give a file"),
        (["in", ""], 3, "the name of the video or picture is empty: give a file"),
    ],
)
def test_inputs_that_are_missing_leave_nothing(mixed, inputs, code, message):
    (mixed / "jobs.csv").write_text("in\ngone.mp4\nlost.mp4\n")
    done = run("batch", *inputs, *WORDS, "out/{name}.mp4")
    assert done.exit_code == code and message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1 and not (mixed / "out").exists()


def test_a_batch_that_goes_on_may_have_lost_its_inputs(mixed):
    (mixed / "jobs.csv").write_text("in\nin/b.mp4\n")
    words = (*WORDS, "out/{name}.{ext}")
    assert run_here("batch", "--list", "jobs.csv", *words).exit_code == 0
    done = run_here("batch", "gone.mp4", *words)
    assert done.exit_code == 5 and "gone.mp4 does not exist" in done.stderr


def test_a_batch_with_a_damaged_input_exits_with_5(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    damage(make_clip(tmp_path / "in.mp4", frames=60, size_wh=(320, 240)))
    done = run_here("batch", "in.mp4", *WORDS, "out/{name}.mp4")
    assert done.exit_code == 5 and "1 of 1 outputs done" in done.stderr
    assert "the input is damaged: " in done.stderr
