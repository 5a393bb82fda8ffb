"""The part file of an output: whatever stands at its path, no other file is written."""

import errno
import os
import subprocess
import sys
from fractions import Fraction
from unittest.mock import Mock

import pytest
from makeup_video.pipeline import OutputError, UsageError, process_video
from makeup_video.pipeline.files import part_file
from makeup_video.pipeline.files.output_file import OutputFile, part_path
from makeup_video.pipeline.files.part_file import PartFile, check_part, remove_ended
from media import decoded, make_clip
from writers import WRITERS, make_picture

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs /proc/self/fd")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(("make", "name"), WRITERS)
@pytest.mark.parametrize("kind", ["link", "broken link", "second name"])
def test_a_link_at_the_part_is_removed_never_followed(tmp_path, make, name, kind):
    victim, part = tmp_path / "victim", part_path(tmp_path / name)
    victim.write_text("precious")
    if kind == "second name":
        os.link(victim, part)
    else:
        part.symlink_to(victim if kind == "link" else tmp_path / "new")
    make(tmp_path, name, overwrite=True)
    assert victim.read_text() == "precious" and not (tmp_path / "new").exists()
    assert (tmp_path / name).stat().st_nlink == 1 and not (tmp_path / name).is_symlink()
    assert not part.is_symlink() and not part.exists()


@LINUX
@pytest.mark.parametrize(("make", "name"), WRITERS)
def test_a_link_that_replaces_the_part_is_never_followed(tmp_path, monkeypatch, make, name):
    victim, part = tmp_path / "victim", part_path(tmp_path / name)
    victim.write_text("precious")

    def create_then_replace(self, *args, **settings):
        original(self, *args, **settings)
        if self.path == tmp_path / name:
            part.unlink()
            part.symlink_to(victim)

    original = OutputFile.__init__
    monkeypatch.setattr(OutputFile, "__init__", create_then_replace)
    with pytest.raises(OutputError, match="replaced by another program"):
        make(tmp_path, name, overwrite=True)
    assert victim.read_text() == "precious" and not (tmp_path / name).exists()
    assert part.is_symlink()  # the other program's link is not removed


def test_a_broken_link_at_the_part_needs_overwrite_too(tmp_path):
    (tmp_path / "out.part.mp4").symlink_to(tmp_path / "new")
    with pytest.raises(UsageError, match="add overwrite=True"):
        process_video(make_clip(tmp_path / "in.mp4"), tmp_path / "out.mp4")
    assert names(tmp_path) == ["in.mp4", "out.part.mp4"]


@pytest.mark.parametrize(("make", "name"), WRITERS)
def test_without_proc_the_part_is_written_by_its_name(tmp_path, monkeypatch, make, name):
    monkeypatch.setattr(part_file, "_OWN_FILES", tmp_path / "no proc")
    own_paths = []

    def create_and_record(self, *args, **settings):
        original(self, *args, **settings)
        own_paths.append(self.own_path)

    original = PartFile.__init__
    monkeypatch.setattr(PartFile, "__init__", create_and_record)
    make(tmp_path, name)
    assert own_paths == [part_path(tmp_path / name)]
    assert (tmp_path / name).stat().st_size > 10


HOLD_PART_FILE = """
import sys
from pathlib import Path
from makeup_video.pipeline.files.part_file import PartFile
part = PartFile(Path(sys.argv[1]), overwrite=True)
print("holds", flush=True)
sys.stdin.read()
"""


def test_the_lock_of_another_process_is_seen_and_ends_with_it(tmp_path):
    part = tmp_path / "out.part.mp4"
    with subprocess.Popen(
        [sys.executable, "-c", HOLD_PART_FILE, part], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout.readline() == b"holds\n"
        with pytest.raises(UsageError, match="another run is writing"):
            PartFile(part, overwrite=True)
        other.kill()
    PartFile(part, overwrite=True).remove()
    assert names(tmp_path) == []


def test_an_ending_run_leaves_the_next_runs_part_alone(tmp_path):
    first = PartFile(tmp_path / "out.part", overwrite=False)
    first.path.unlink()  # deleted by hand, so that another run can take the name
    second = PartFile(tmp_path / "out.part", overwrite=False)
    second.own_path.write_text("second")
    first.remove()
    assert (tmp_path / "out.part").read_text() == "second"
    with pytest.raises(UsageError, match="another run is writing"):
        PartFile(tmp_path / "out.part", overwrite=True)
    second.remove()


def test_an_output_that_is_a_link_is_still_written_through(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "out.png").write_text("old")
    (tmp_path / "out.png").symlink_to("real/out.png")
    make_picture(tmp_path, "out.png", overwrite=True)
    assert (tmp_path / "out.png").is_symlink() and names(tmp_path / "real") == ["out.png"]


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_every_container_is_finished_by_the_own_path(tmp_path, end):
    """+faststart reads the file again, and Matroska's display size is written into the file."""
    src = make_clip(tmp_path / "in.mp4", audio="aac", sample_aspect_ratio=Fraction(4, 3))
    report = process_video(src, tmp_path / f"out{end}")
    assert len(decoded(tmp_path / f"out{end}")) == report.frames_out == 12
    assert report.bytes_out == (tmp_path / f"out{end}").stat().st_size
    assert not [text for text in report.dropped if "aspect" in text]


@pytest.mark.parametrize(("make", "name"), WRITERS)
def test_a_folder_at_the_outputs_place_keeps_the_part(tmp_path, make, name):
    with pytest.raises(OutputError, match=r"cannot be renamed to .* rename it"):
        make(tmp_path, name, lambda: (tmp_path / name).mkdir(exist_ok=True), overwrite=True)
    part = part_path(tmp_path / name)
    assert part.stat().st_size > 0 and (tmp_path / name).is_dir()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such locks")
def test_a_part_that_is_being_written_is_no_leftover(tmp_path):
    """Nobody is told to overwrite what another run is writing."""
    running = PartFile(tmp_path / "out.part.mp4", overwrite=False)
    with pytest.raises(UsageError, match="another run is writing"):
        check_part(running.path, overwrite=False)
    running.close()
    for _ in range(2):  # the check leaves no lock behind
        with pytest.raises(UsageError, match="perhaps from a run that was stopped"):
            check_part(running.path, overwrite=False)


def test_a_name_that_is_too_long_has_no_part_to_remove(tmp_path):
    remove_ended(tmp_path / ("x" * 300))


def test_empty_open_parts_are_removed_at_exit(tmp_path):
    empty, begun, left = (PartFile(tmp_path / name, overwrite=False) for name in "abc")
    begun.own_path.write_bytes(b"something")
    left.close()
    part_file.remove_empty()
    assert names(tmp_path) == ["b", "c"]
    empty.close()
    begun.close()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such locks")
@pytest.mark.parametrize(
    ("number", "is_busy"),
    [(errno.EWOULDBLOCK, True), (errno.EACCES, True), (errno.ENOLCK, False),
     (errno.ENOSYS, False), (errno.EOPNOTSUPP, False)],
)  # fmt: skip
def test_a_file_system_without_locks_is_no_other_run(tmp_path, monkeypatch, number, is_busy):
    import fcntl

    monkeypatch.setattr(fcntl, "flock", Mock(side_effect=OSError(number, os.strerror(number))))
    if is_busy:
        with pytest.raises(UsageError, match="another run is writing"):
            PartFile(tmp_path / "part", overwrite=False)
    else:
        PartFile(tmp_path / "part", overwrite=False).remove()
        assert names(tmp_path) == []


STOPPED_WHILE_OPENING = """
import os, signal, sys, time
from makeup_video.cli import main
from makeup_video.pipeline.files import part_file

lock = part_file.lock_file

def stopped(fd):
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(1)
    return lock(fd)

part_file.lock_file = stopped
main.main()
"""


def test_a_ctrl_c_while_the_part_is_made_leaves_nothing(tmp_path):
    make_clip(tmp_path / "in.mp4")
    command = [
        sys.executable,
        "-c",
        STOPPED_WHILE_OPENING,
        "in.mp4",
        "--look",
        "none",
        "-o",
        "o.mp4",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "stopped\n")
    assert names(tmp_path) == ["in.mp4"]
