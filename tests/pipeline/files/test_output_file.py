"""The output path: no existing file is lost, and no two runs share the path."""

import errno
import os

import pytest
from makeup_video.pipeline import (
    InputError,
    Look,
    OutputError,
    Settings,
    StoppedError,
    UsageError,
    process_looks,
    process_video,
)
from makeup_video.pipeline.files.output_file import (
    OutputFile,
    check_apart,
    keep_apart,
    part_path,
    target_of,
    write_errors,
)
from makeup_video.pipeline.files.template import Origin
from media import decoded, make_clip


@pytest.fixture
def source(tmp_path):
    return make_clip(tmp_path / "in.mp4")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_part_becomes_the_output_stays_or_is_removed(tmp_path, source):
    target = OutputFile(tmp_path / "a.mp4", source, overwrite=False)
    target.part.write_text("whole")
    target.keep()
    target = OutputFile(tmp_path / "b.mp4", source, overwrite=False)
    target.leave()
    target = OutputFile(tmp_path / "c.mp4", source, overwrite=False)
    target.discard()
    assert names(tmp_path) == ["a.mp4", "b.part.mp4", "in.mp4"]
    assert (tmp_path / "a.mp4").read_text() == "whole"


def test_a_nul_in_the_name_of_an_output_is_one_line(tmp_path, source):
    looks = {tmp_path / "a\0.mp4": Look(), tmp_path / "b.mp4": Look()}
    gone = r"'.*\\x00\.mp4' has a NUL"
    with pytest.raises(OutputError, match=gone):
        process_video(source, tmp_path / "a\0.mp4", None)
    with pytest.raises(OutputError, match=gone):
        process_looks(source, looks)
    with pytest.raises(OutputError, match="no file has such a name; choose another"):
        Look().save(tmp_path / "a\0.json")
    assert names(tmp_path) == ["in.mp4"]


@pytest.mark.parametrize("overwrite", [False, True])
def test_the_input_may_lie_where_the_output_would_grow(tmp_path, source, overwrite):
    """A part file that Ctrl-C left behind is a valid input and must not be destroyed."""
    part = source.rename(tmp_path / "video.part.mp4")
    before = part.read_bytes()
    with pytest.raises(UsageError, match="under which this output would be written"):
        process_video(part, tmp_path / "video.mp4", None, Settings(overwrite=overwrite))
    assert part.read_bytes() == before and names(tmp_path) == ["video.part.mp4"]


def test_an_old_part_is_only_overwritten_when_asked(tmp_path, source):
    (tmp_path / "out.part.mp4").write_text("precious")
    with pytest.raises(UsageError, match="add overwrite=True"):
        process_video(source, tmp_path / "out.mp4")
    assert (tmp_path / "out.part.mp4").read_text() == "precious"
    process_video(source, tmp_path / "out.mp4", None, Settings(overwrite=True))
    assert names(tmp_path) == ["in.mp4", "out.mp4"]


def test_two_runs_cannot_write_the_same_output(tmp_path, source):
    first = OutputFile(tmp_path / "out.mp4", source, overwrite=True)
    with pytest.raises(UsageError, match="another run is writing"):
        OutputFile(tmp_path / "out.mp4", source, overwrite=True)
    first.discard()
    OutputFile(tmp_path / "out.mp4", source, overwrite=True).discard()


def test_a_link_is_written_through(tmp_path, source):
    (tmp_path / "real.mp4").write_text("old")
    (tmp_path / "link.mp4").symlink_to("real.mp4")
    process_video(source, tmp_path / "link.mp4", None, Settings(overwrite=True))
    assert (tmp_path / "link.mp4").is_symlink()
    assert len(decoded(tmp_path / "real.mp4")) == 12


@pytest.mark.parametrize("place", ["output", "part"])
def test_a_pipe_is_never_replaced(tmp_path, source, place):
    path = tmp_path / "out.mp4"
    os.mkfifo(path if place == "output" else part_path(path))
    with pytest.raises(OutputError, match=r"no file|not an ordinary file"):
        process_video(source, path, None, Settings(overwrite=True))


@pytest.mark.parametrize("name", ["x" * 300 + ".mp4", "x" * 253 + ".mp4"])
def test_a_name_too_long_for_the_disk_is_an_output_error(tmp_path, source, name):
    with pytest.raises(OutputError, match="name"):
        process_video(source, tmp_path / name)
    assert names(tmp_path) == ["in.mp4"]


def test_names_too_long_are_compared_like_others(tmp_path):
    long = tmp_path / ("x" * 300)
    assert target_of(long) == long
    check_apart([long, tmp_path / "a.mp4"])
    keep_apart(long, tmp_path / "a.mp4")
    with pytest.raises(UsageError, match="two outputs have the name"):
        check_apart([long, long])


def test_inputs_that_no_field_tells_apart_may_be_renamed(tmp_path):
    values = {"name": "a", "folder": "clips", "ext": "mp4"}
    origins = [Origin(values, source, "glam") for source in ("clips/a.avi", "clips/a.mp4")]
    with pytest.raises(UsageError, match=r"give each its own, or rename an input$") as caught:
        check_apart([tmp_path / "a.mp4"] * 2, origins)
    assert "(clips/a.avi and clips/a.mp4)" in str(caught.value)


def test_an_output_that_names_a_folder_is_refused(tmp_path, source):
    with pytest.raises(UsageError, match="names a folder"):
        process_video(source, f"{tmp_path}/new.mp4/")


@pytest.mark.parametrize("error", [InputError("in.mp4 is not a video"), StoppedError("stopped")])
def test_errors_about_inputs_are_not_those_of_the_output(tmp_path, error):
    with pytest.raises(type(error)) as caught, write_errors(tmp_path / "out.mp4"):
        raise error
    assert caught.value is error


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EACCES, errno.EROFS, errno.EIO])
def test_the_advice_fits_the_error(tmp_path, code):
    with pytest.raises(OutputError) as caught, write_errors(tmp_path / "out.mp4"):
        raise OSError(code, os.strerror(code))
    text = str(caught.value)
    assert os.strerror(code) in text and text.count("\n") == 0
    assert ("space" in text) == (code == errno.ENOSPC)
