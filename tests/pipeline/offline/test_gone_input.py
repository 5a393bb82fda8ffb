"""An input that is removed or replaced during the run: the opened file is read to its end."""

import os

import pytest
from makeup_video.pipeline import InputError
from makeup_video.pipeline.files.output_file import OutputFile
from makeup_video.pipeline.offline import run as offline_run
from makeup_video.pipeline.offline.process import process_video
from media import decoded, make_clip
from writers import make_picture, run


@pytest.fixture(params=["in.mp4", "in.mkv", "in.png"])
def source(tmp_path, request):
    if request.param == "in.png":
        make_picture(tmp_path, "copy.png")
        return tmp_path / "in.png"
    return make_clip(tmp_path / request.param)


@pytest.mark.parametrize("change", ["removed", "replaced"])
def test_the_run_ends_well_and_reports_what_was_read(tmp_path, source, change):
    size = source.stat().st_size
    dst = tmp_path / f"out{source.suffix}"
    run(source, tmp_path / f"want{source.suffix}", lambda: None)

    def disturb():
        if change == "removed":
            source.unlink(missing_ok=True)
        else:
            (tmp_path / "other").write_bytes(b"x" * 9)
            os.replace(tmp_path / "other", source)

    report = run(source, dst, disturb)
    assert report.bytes_in == size and report.warnings() == []
    assert report.bytes_out == dst.stat().st_size
    assert len(decoded(dst)) == report.frames_out == report.frames_in
    assert report.frames_out == len(decoded(tmp_path / f"want{source.suffix}"))


@pytest.mark.parametrize("checks", [0, 1])
def test_an_input_that_goes_before_it_is_opened_is_one_line(tmp_path, source, monkeypatch, checks):
    """checks: how many of the two checks of the input's kind still find the file."""

    def remove_and_check(path, *args):
        if not checks:
            path.unlink()
        kind = original(path, *args)
        path.unlink(missing_ok=True)
        return kind

    original = offline_run.is_picture
    monkeypatch.setattr(offline_run, "is_picture", remove_and_check)
    with pytest.raises(InputError, match="No such file") as caught:
        process_video(source, tmp_path / f"out{source.suffix}")
    assert str(source) in str(caught.value) and "\n" not in str(caught.value)
    assert not list(tmp_path.glob("out*"))


def test_an_output_is_replaced_when_the_input_is_gone(tmp_path, source):
    out = tmp_path / "out.mp4"
    out.write_text("old")
    source.unlink()
    target = OutputFile(out, source, overwrite=True)
    target.own_path.write_text("new")
    target.keep()
    assert out.read_text() == "new"
