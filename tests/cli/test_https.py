"""`--https`, `--certificate` and `--key` of the page."""

import os
import re
import stat

import pytest
from makeup_video.cli.app import app
from makeup_video.web.certificate import lan_address, own_certificate
from people import clip, write_video
from typer.testing import CliRunner


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    write_video(tmp_path / "in.mkv", clip(3))
    return tmp_path


def run(*args):
    """`live` on a video: it ends by itself."""
    command = ["live", "--camera", "in.mkv", "--port", "0", "--no-browser", *map(str, args)]
    return CliRunner().invoke(app, command)


def test_https_makes_a_certificate_and_says_browsers_warn(folder):
    done = run("--https")
    assert done.exit_code == 0, done.output
    assert re.search(r"^https://127\.0\.0\.1:\d+/ shows the page", done.output, re.MULTILINE)
    assert "browsers warn about its certificate" in done.output
    if os.name == "posix":
        (file,) = (folder / "data" / "makeup-video").iterdir()
        assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_a_certificate_of_one_s_own_implies_https(folder):
    file = own_certificate("127.0.0.1", folder / "own")
    done = run("--certificate", file)
    assert done.exit_code == 0 and "https://127.0.0.1" in done.output
    assert "browsers warn" not in done.output and not (folder / "data").exists()
    done = run("--certificate", file, "--key", file)
    assert done.exit_code == 0 and "https://127.0.0.1" in done.output


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--key", "in.mkv"), "--key belongs to a certificate"),
        (("--certificate", "none.pem"), "none.pem is not a file"),
        (("--certificate", "in.mkv"), "in.mkv and the key in it are not a certificate"),
    ],
)
def test_faults_of_the_files_are_one_line(folder, args, words):
    done = run(*args)
    assert done.exit_code not in (0, 1) and words in done.output
    assert len(done.output.splitlines()) == 1


def test_a_page_open_to_all_names_its_address_for_others(folder):
    if lan_address() is None:
        pytest.skip("this machine has no network")
    done = run("--host", "0.0.0.0")
    assert re.search(
        rf"can open the page at http://{re.escape(lan_address())}:\d+/ and", done.output
    )
