"""Training commands name a missing input, and what makes it."""

import argparse
import subprocess
import sys

import pytest
from makeup_video.training.inputs import existing, made_by


def test_paths_that_exist_are_taken(tmp_path):
    for of_type in (existing, made_by("faces.prepare")):
        assert of_type(str(tmp_path)) == tmp_path


@pytest.mark.parametrize(
    ("of_type", "says"),
    [(existing, "name a file"), (made_by("faces.prepare"), "training.faces.prepare first")],
    ids=["existing", "made by a command"],
)
def test_a_missing_path_is_named_with_what_to_do(of_type, says, tmp_path):
    with pytest.raises(argparse.ArgumentTypeError, match=says) as told:
        of_type(str(tmp_path / "gone.npz"))
    assert "gone.npz" in str(told.value) and "\n" not in str(told.value)


@pytest.mark.parametrize("command", ["faces.fit_shut_eyes", "list_hashes", "shade_names"])
def test_a_command_without_its_input_ends_without_a_traceback(command, tmp_path):
    words = {
        "faces.fit_shut_eyes": ["--faces", "gone", "--out", "eyes.npy"],
        "list_hashes": ["gone"],
        "shade_names": ["--table", "gone", "red"],
    }[command]
    ended = subprocess.run(
        [sys.executable, "-m", f"makeup_video.training.{command}", *words],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 2 and "there is no gone" in ended.stderr
    assert "Traceback" not in ended.stderr
