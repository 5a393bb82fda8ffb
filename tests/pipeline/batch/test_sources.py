"""The inputs of a batch: files, folders and patterns; each file counts once."""

import pytest
from makeup_video.pipeline import InputError, UsageError
from makeup_video.pipeline.batch.sources import check_some_exist, inputs_of, left_out_of


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("clips/b.mp4", "clips/a.MOV", "clips/note.txt", "clips/b-red.mp4",
                 "clips/c.part.mp4", "clips/deep/d.mkv", "clips/f.jpg", "clips/._a.mp4", "empty/x.txt"):  # fmt: skip
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text("x")
    return tmp_path


@pytest.mark.parametrize(
    ("given", "files"),
    [
        (["clips"], ["clips/a.MOV", "clips/b-red.mp4", "clips/b.mp4", "clips/f.jpg"]),
        (["clips/**/*.m*"], ["clips/b-red.mp4", "clips/b.mp4", "clips/deep/d.mkv"]),
        (["clips/b.mp4", "clips", "./clips/b.mp4"],
         ["clips/b.mp4", "clips/a.MOV", "clips/b-red.mp4", "clips/f.jpg"]),
        (["missing.mp4", "clips/f.jpg"], ["missing.mp4", "clips/f.jpg"]),
        (["clips/note.txt"], ["clips/note.txt"]),
    ],
)  # fmt: skip
def test_files_folders_and_patterns(folder, given, files):
    assert inputs_of(given) == files


def test_outputs_of_the_batch_are_no_inputs(folder):
    written = [folder / "clips" / "b-red.mp4"]
    assert "clips/b-red.mp4" not in inputs_of(["clips"], written)
    assert "clips/b-red.mp4" not in inputs_of(["clips/*.mp4"], written)
    assert inputs_of(["clips/b-red.mp4"], written) == ["clips/b-red.mp4"]
    # several names may come from a pattern that the shell has expanded
    assert inputs_of(["clips/b-red.mp4", "clips/b.mp4"], written) == ["clips/b.mp4"]


@pytest.mark.parametrize("given", ["clips", "clips/*.m*"])
def test_of_a_file_and_links_to_it_the_file_counts(folder, given):
    (folder / "clips" / "a-link.mp4").symlink_to("b.mp4")  # sorts before b.mp4
    (folder / "clips" / "z-link.mp4").symlink_to("b.mp4")
    (folder / "clips" / "far.mp4").symlink_to("deep/d.mkv")
    found = inputs_of([given])
    assert not [one for one in found if "-link" in one]
    assert found.index("clips/b.mp4") > found.index("clips/b-red.mp4")
    assert "clips/far.mp4" in found  # the only name of deep/d.mkv here
    assert inputs_of(["clips/a-link.mp4"]) == ["clips/a-link.mp4"]
    assert inputs_of(["clips/a-link.mp4", given]) == found


@pytest.mark.parametrize("given", ["clips", "clips/*.m*"])
def test_a_link_that_leads_nowhere_is_a_job_that_fails(folder, given):
    (folder / "clips" / "lost.mp4").symlink_to("gone.mp4")
    (folder / "clips" / "self.mp4").symlink_to("self.mp4")
    assert {"clips/lost.mp4", "clips/self.mp4", "clips/b.mp4"} <= set(inputs_of([given]))


@pytest.mark.parametrize(
    ("given", "message"),
    [("empty", "empty has no videos or pictures: give"), ("*.avi", "matches no file: give"),
     ("parts", "parts has no videos or pictures: give")],
)  # fmt: skip
def test_nothing_found_is_an_error(folder, given, message):
    (folder / "parts").mkdir()
    (folder / "parts" / "c.part.mp4").touch()
    with pytest.raises(UsageError, match=message):
        inputs_of([given])


def test_inputs_of_which_none_exists_are_a_mistake(folder):
    with pytest.raises(UsageError, match=r"^gone.mp4 does not exist: give files, a folder"):
        check_some_exist(["gone.mp4", "lost.mp4"])
    with pytest.raises(UsageError, match=r"^a.csv, line 2: gone.mp4 does not exist: give files"):
        check_some_exist(["gone.mp4", "lost.mp4"], "a.csv, line 2")
    check_some_exist(["gone.mp4", "clips/b.mp4"])


def test_an_empty_name_is_refused_as_by_every_command(folder):
    with pytest.raises(
        InputError, match=r"^the name of the video or picture is empty: give a file"
    ):
        inputs_of(["clips", ""])


def test_pictures_of_a_folder_that_are_not_painted_are_known(folder):
    for name in ("p.avif", "P.TIF", "q.tiff", "b.bmp", ".hidden.tif"):
        (folder / "empty" / name).touch()
    named = ["empty/P.TIF", "empty/b.bmp", "empty/p.avif", "empty/q.tiff"]
    assert left_out_of(["clips", "empty", "empty", "empty/x.txt"]) == named
    with pytest.raises(UsageError, match="but AVIF, BMP and TIFF pictures, which are not painted"):
        inputs_of(["empty"])
