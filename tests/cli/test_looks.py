"""`makeup-video looks`: the ready looks as a list, as JSON and as look files."""

import json

import pytest
from command_line import run
from makeup_video.pipeline import Look, ready_looks

NAMES = [one.name for one in ready_looks()]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_ready_look_is_listed_with_its_words():
    done = run("looks")
    assert done.exit_code == 0
    lines, width = done.stdout.splitlines(), max(map(len, NAMES))
    assert [(line[:width].strip(), line[width:].strip()) for line in lines] == [
        (one.name, one.words) for one in ready_looks()
    ]


def test_programs_get_names_words_and_looks():
    rows = json.loads(run("looks", "--json").stdout)
    assert [row["name"] for row in rows] == NAMES
    assert [Look.from_dict(row["look"]) for row in rows] == [one.look for one in ready_looks()]


@pytest.mark.parametrize("one", ready_looks(), ids=NAMES)
def test_a_look_is_printed_and_written_as_a_look_file(folder, one):
    printed = run("looks", one.name)
    assert printed.exit_code == 0 and Look.from_dict(json.loads(printed.stdout)) == one.look
    done = run("looks", one.name, "-o", "mine.json")
    assert (done.exit_code, done.output) == (0, "mine.json: look file written\n")
    assert Look.load("mine.json") == one.look
    assert (folder / "mine.json").read_text() == printed.stdout


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["caty-eye"], 2, "LookError: there is no ready look 'caty-eye': did you mean cat-eye? Ready"),
        (["glam", "-o", "old.json"], 2, "old.json exists already: add -y"),
        (["glam", "-o", ""], 2, "the name of the look file is empty"),
        (["glam", "-o", "glam.PNG"], 2, "the look file glam.PNG has the name of a picture or a video: end it in .json"),
        (["glam", "-o", "glam.mp4"], 2, "end it in .json"),
        (["glam", "-o", "no/mine.json"], 4, "the folder no does not exist"),
        (["-o", "mine.json"], 2, "UsageError: -o writes one look: add its NAME, or leave -o out"),
        (["glam", "berry"], 2, ""),
    ],
)  # fmt: skip
def test_each_mistake_leaves_every_file_alone(folder, words, code, message):
    (folder / "old.json").write_text("precious")
    done = run("looks", *words)
    if message:
        assert (done.exit_code, len(done.output.splitlines())) == (code, 1)
        assert message in done.output
    assert done.exit_code == code
    assert {path.name for path in folder.iterdir()} == {"old.json"}
    assert (folder / "old.json").read_text() == "precious"


def test_yes_overwrites_an_old_look(folder):
    (folder / "old.json").write_text("old")
    assert run("looks", "glam", "-o", "old.json", "-y").exit_code == 0
    assert Look.load("old.json").of("eyeliner")
