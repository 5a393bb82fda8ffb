"""`makeup-video demo` prints the address of the page and exits with 0 after Ctrl-C."""

import re
import signal
import socket
import subprocess
import sys

import cv2
import httpx
import pytest
from makeup_video.cli.app import app
from makeup_video.pipeline import Look, look_from_photo
from people import SAMPLES, grey
from shows import RED, Page
from typer.testing import CliRunner

COMMAND = [sys.executable, "-m", "makeup_video.cli", "demo", "--no-browser", "--port", "0"]


def running(*args):
    return subprocess.Popen([*COMMAND, *map(str, args)], stderr=subprocess.PIPE, text=True)


def address(process):
    line = process.stderr.readline()
    found = re.match(r"(http://127\.0\.0\.1:\d+)/ shows the page; Ctrl-C ends it\n", line)
    assert found, line
    return found[1]


def ended(process, number):
    process.send_signal(number)
    _, stderr = process.communicate(timeout=30)
    return process.returncode, stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_serves_the_page_until_stopped_and_succeeds(number):
    process = running()
    url = address(process)
    assert httpx.get(url).headers["content-type"].startswith("text/html")
    with Page(url) as page:
        assert page.hello["mode"] == "demo" and len(page.hello["look"]["layers"]) == 1
        assert len(page.picture()[2]) > 10_000
        assert ended(process, number) == (0, "stopped\n")


def test_the_page_begins_with_the_given_look_file(tmp_path):
    RED.save(tmp_path / "look.json")
    process = running("--look", tmp_path / "look.json")
    with Page(address(process)) as page:
        assert Look.from_dict(page.hello["look"]) == RED
    assert ended(process, signal.SIGINT)[0] == 0


def test_it_begins_with_a_photo_and_a_portrait_of_the_user():
    process = running(SAMPLES / "portrait.jpg", "--ref", SAMPLES / "look.jpg")
    with Page(address(process)) as page:
        assert Look.from_dict(page.hello["look"]) == look_from_photo(SAMPLES / "look.jpg")
    assert ended(process, signal.SIGINT)[0] == 0


def refusal(*args):
    done = CliRunner().invoke(app, ["demo", "--no-browser", *map(str, args)])
    assert len(done.output.splitlines()) == 1
    return done.exit_code, done.output


def test_mistakes_are_one_line_before_the_page_is_served(tmp_path):
    cv2.imwrite(str(tmp_path / "wall.png"), grey())
    assert refusal(tmp_path / "none.jpg")[0] == 3
    code, stderr = refusal(tmp_path / "wall.png")
    assert code == 3 and "wall.png: no face was found" in stderr
    assert refusal("--ref", tmp_path / "none.jpg")[0] == 3
    assert refusal("--look", tmp_path / "none.json")[0] == 2
    code, stderr = refusal("--ref", "a.jpg", "--look", "b.json")
    assert code == 2 and "leave one of them out" in stderr
    assert refusal("--port", "70000")[0] == 2


def test_a_port_that_is_taken_is_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, stderr = refusal("--port", port)
    assert code == 2 and f"port {port} on 127.0.0.1 is taken" in stderr
