"""Two versions of the product in turn. Nothing here is timed."""

import json
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.benchmark import against, harness
from makeup_video.benchmark.runs import Run
from makeup_video.benchmark.tables import tables, verdicts
from makeup_video.cli.app import app
from makeup_video.pipeline import InputError, Look, UsageError, product
from people import SAMPLES
from typer.testing import CliRunner

LOOK = Look(lips=product((150, 30, 70), "satin"))
FRAMES = 15
# An interpreter of another version: it answers --version, and writes the report of a run.
FAKE = """#!{python}
import json, sys
if sys.argv[-1] == "--version":
    print("makeup-video 0.0.1")
elif {error!r}:
    sys.exit({error!r})
else:
    report = sys.argv[sys.argv.index("--report") + 1]
    json.dump({report!r}, open(report, "w"))
"""


@pytest.fixture
def bench(tmp_path):
    return harness.Bench(SAMPLES / "in.mp4", tmp_path, LOOK, seconds=FRAMES / 30, rounds=1)


@pytest.fixture
def fake(tmp_path):
    def make(report=None, error="", name="python"):
        path = tmp_path / name
        path.write_text(FAKE.format(python=sys.executable, report=report, error=error))
        path.chmod(0o755)
        return str(path)

    return make


@pytest.fixture
def fake_ours(fake, monkeypatch):
    """This version is fake as well: its real command takes seconds, and is run by a test below."""
    stages = {name: {"cpu_seconds": 0.1} for name in ("decode", "faces", "encode")}
    report = {"frames_out": FRAMES, "painted_frames": FRAMES, "peak_memory_bytes": 10**8}
    ours = fake(report | {"stages": stages, "first_packet_unix_seconds": 9e9}, name="ours")
    monkeypatch.setattr(against, "this_version", lambda: against.Version("0.2.0", ours))
    return Path(ours)


def ran():
    return st.builds(
        against.Ran,
        st.builds(Run, st.integers(1, 999), st.floats(0.01, 99), st.floats(0.01, 99)),
        st.floats(0.01, 9) | st.none(),
        st.floats(1, 999),
        st.fixed_dictionaries({name: st.floats(0.01, 99) for name in ("decode", "faces")}),
    )


@given(st.lists(st.tuples(ran(), ran()), min_size=1, max_size=9))
def test_ratios_lie_within_their_spread(pairs):
    ours, others = map(list, zip(*pairs, strict=True))
    known = ("cpu", "stages", "wall", "memory")
    for side in (against.compare_runs(ours, others), against.compare_runs(ours, ours)):
        for name in known:
            low, high = side[name]["spread"]
            assert 0 < low <= side[name]["ratio"] <= high
    assert {side[name]["ratio"] for name in known} == {1}
    by_stage = against.compare_stages(ours, others)
    assert by_stage["faces"]["ratio"] == against.compare_runs(ours, others)["stages"]["ratio"]
    unknown = any(one.start_seconds is None for one in ours)
    assert (side["start"] is None) == unknown


def test_this_version_beside_itself_runs_the_real_command(bench, monkeypatch):
    monkeypatch.setattr(against, "_WARM_RUNS", 1)
    other = against.other_version(sys.executable)
    assert other == against.this_version()
    found = against.compare_versions(bench, [144], other)
    size = found["sizes"]["144p"]
    assert found["this"] == found["other"] and size["this"]["fps"] > 0
    assert size["other"]["peak_memory_mb"] > 20 and size["other"]["start_seconds"] > 0
    assert list(size["by_stage"])[::5] == ["decode", "encode"]
    ((_, head, rows),) = tables({"against": found})
    assert {len(row) for row in rows} == {len(head)} and "unknown" not in str(rows)


def test_the_verdict_is_one_line_with_ratio_and_spread():
    size = {name: {"ratio": 0.93, "spread": [0.912, 0.958]} for name in ("cpu", "wall")}
    (line,) = verdicts({"against": {"other": "0.1.0", "sizes": {"720p": size}}})
    assert line.startswith("this version takes 0.93 (0.91-0.96) of the CPU time of 0.1.0 at 720p")


@pytest.mark.parametrize("python", ["/no/such/python", sys.executable.replace("python", "pyton")])
def test_a_missing_interpreter_is_refused(python):
    with pytest.raises(UsageError, match="against must be a Python interpreter that has makeup"):
        against.other_version(python)


def test_an_interpreter_without_the_product_is_refused(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", ":".join(filter(None, sys.path)))  # this path must not count
    with pytest.raises(UsageError, match="No module named makeup_video"):
        against.other_version(sys._base_executable)


@pytest.mark.parametrize("painted", [0, 14, None])
def test_a_version_that_paints_too_few_frames_is_refused(bench, fake_ours, fake, painted):
    report = {"frames_out": FRAMES, "painted_frames": painted}
    other = against.other_version(fake(report))
    assert other.name == "0.0.1"
    with pytest.raises(InputError, match=f"in {painted or 0} of 15 frames, at least 95%"):
        against.compare_versions(bench, [144], other)


def test_a_version_that_loses_frames_is_refused(bench, fake_ours, fake):
    other = against.other_version(fake({"frames_out": 5, "painted_frames": 5}))
    with pytest.raises(InputError, match="in 5 of 15 frames"):
        against.compare_versions(bench, [144], other)


def test_a_report_of_counts_alone_is_enough(bench, fake_ours, fake):
    other = against.other_version(fake({"frames_out": FRAMES, "painted_frames": FRAMES}))
    found = against.compare_versions(bench, [144], other)
    size = found["sizes"]["144p"]
    assert min(size["this"][key] for key in ("start_seconds", "peak_memory_mb", "stages_ms")) > 0
    assert size["start"] is size["memory"] is size["stages"] is None and size["cpu"]["ratio"] > 0
    assert size["by_stage"] == {}
    assert "unknown" in str(list(tables({"against": found})))


def test_what_the_other_version_refuses_is_said_in_its_words(bench, fake_ours, fake):
    other = against.other_version(fake(error="UsageError: version 2 is not known"))
    with pytest.raises(UsageError, match=r"0\.0\.1 \(.*version 2 is not known"):
        against.compare_versions(bench, [144], other)


def run(*words):
    clip = ("bench", str(SAMPLES / "in.mp4"), "--sizes", "144p", "--seconds", "0.5")
    return CliRunner().invoke(app, [*clip, "--rounds", "1", *words])


def test_the_command_prints_json(fake_ours, fake):
    report = {"frames_out": FRAMES, "painted_frames": FRAMES}
    done = run("--against", fake(report), "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["against"]["other"] == "0.0.1"


def test_both_versions_read_the_look_file_that_was_given(fake_ours, fake, tmp_path):
    """An older version may not read the file that this version would write."""
    file = tmp_path / "own.json"
    LOOK.save(file)
    other = Path(fake({"frames_out": FRAMES, "painted_frames": FRAMES}))
    strict = f"elif {str(file)!r} not in sys.argv:\n    sys.exit('another look')\nelse:"
    for python in (fake_ours, other):
        python.write_text(python.read_text().replace("else:", strict))
    done = run("--against", str(other), "--look", str(file), "--json")
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize("more", [["--live"], ["--faces"], ["--length", "1"], ["--plot", "a.png"]])
def test_it_is_measured_alone(more):
    done = run("--against", sys.executable, *more)
    assert done.exit_code == 2 and "--against is measured alone" in done.stderr
