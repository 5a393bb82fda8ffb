"""Planning a batch: it checks finished work, finds interrupted work, keeps or retries failures."""

from dataclasses import replace

import pytest
from makeup_video.pipeline import (
    InputError,
    Look,
    OutputError,
    Settings,
    StrictError,
    UsageError,
    WorkerError,
    process_video,
    product,
)
from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook
from makeup_video.pipeline.batch.journal import Journal
from makeup_video.pipeline.batch.plan import check_inputs_apart, is_hopeless, is_whole, plan_batch
from makeup_video.pipeline.batch.task import do_job, run_job
from makeup_video.pipeline.images import picture_size
from media import make_clip
from picture_files import scene, write

BARE = Look()
RED = Look(lips=product((180, 0, 40), "satin"))


class Case:
    """One video without a face, one output, one journal."""

    def __init__(self, folder):
        self.output = folder / "out.mp4"
        self.part = folder / "out.part.mp4"
        source = make_clip(folder / "in.mp4")
        self.job = Job(str(source), (JobLook("none", BARE, str(self.output)),), Settings())
        self.journal = Journal(folder / "j.jsonl")

    def paint(self):
        return run_job(self.job, lambda progress: None)

    def plan(self, retry=False, overwrite=False):
        return plan_batch([self.job], self.journal, retry=retry, overwrite=overwrite)

    def known(self, **how):
        plan = self.plan(**how)
        assert plan.todo == []
        (result,) = plan.known.values()
        return result


@pytest.fixture
def case(tmp_path):
    case = Case(tmp_path)
    yield case
    case.journal.close()


def test_an_own_picture_larger_than_any_input_is_whole(tmp_path, monkeypatch):
    """A before-and-after picture has twice the pixels of the input."""
    large = write(tmp_path / "large.png", scene())
    monkeypatch.setattr(picture_size, "MOST_PX", 1000)
    assert is_whole(str(large), 1)
    large.write_bytes(large.read_bytes()[:200])
    assert not is_whole(str(large), 1)


def test_new_work_is_to_be_done(case):
    assert case.plan().todo == [case.job]


def test_done_work_is_checked_and_not_done_again(case):
    case.journal.begin(case.job)
    results = case.paint()
    case.journal.end(case.job, results)
    assert case.known() == results[0] and isinstance(results[0], Done)


@pytest.mark.parametrize("begun", [False, True])
def test_a_file_of_somebody_else_is_never_overwritten(case, begun):
    case.output.write_text("mine")
    if begun:
        case.journal.begin(case.job)
    with pytest.raises(UsageError, match="exists already") as caught:
        case.plan()
    assert "since the journal" not in str(caught.value)
    assert case.plan(overwrite=True).todo == [case.job]
    assert case.output.read_text() == "mine"


def test_an_output_of_another_look_says_so(case):
    case.journal.begin(case.job)
    case.journal.end(case.job, case.paint())
    (look,) = case.job.looks
    other = Job(case.job.source, (JobLook("red", RED, look.output),), Settings())
    with pytest.raises(UsageError, match="since the journal has it from another input, look or"):
        plan_batch([other], case.journal, retry=False, overwrite=False)


def test_an_input_that_is_gone_leaves_finished_work_alone(case, tmp_path):
    case.journal.begin(case.job)
    (done,) = case.paint()
    case.journal.end(case.job, [done])
    (tmp_path / "in.mp4").unlink()
    assert case.known() == done == case.known(overwrite=True)
    case.output.write_bytes(b"something else")
    assert "has changed since the batch wrote it" in str(case.known().error)
    case.output.unlink()
    assert case.plan().todo == [case.job]  # fails alone


@pytest.mark.parametrize("other", ["look", "input", "settings"])
def test_without_its_input_other_work_is_not_taken_for_done(case, tmp_path, other):
    case.journal.begin(case.job)
    case.journal.end(case.job, case.paint())
    (tmp_path / "in.mp4").unlink()
    (look,) = case.job.looks
    job = {
        "look": replace(case.job, looks=(replace(look, look=RED),)),
        "input": replace(case.job, source=str(tmp_path / "typo.mp4")),
        "settings": replace(case.job, settings=Settings(crf=30)),
    }[other]
    plan = plan_batch([job], case.journal, retry=False, overwrite=False)
    assert plan.todo == [job] and not plan.known


@pytest.mark.parametrize("overwrite", [False, True])
def test_without_its_input_no_output_of_others_is_touched(case, tmp_path, overwrite):
    case.output.write_text("mine")
    (tmp_path / "in.mp4").unlink()
    assert case.plan(overwrite=overwrite).todo == [case.job]
    (failed,) = case.paint()
    assert isinstance(failed.error, InputError) and case.output.read_text() == "mine"


def test_an_output_that_is_gone_is_made_again(case):
    case.journal.begin(case.job)
    case.journal.end(case.job, case.paint())
    case.output.unlink()
    assert case.plan().todo == [case.job]


@pytest.mark.parametrize("damage", ["cut", "garbage"])
def test_a_changed_output_is_named_and_left_alone(case, damage):
    case.journal.begin(case.job)
    case.journal.end(case.job, case.paint())
    data = case.output.read_bytes()
    case.output.write_bytes(data[: len(data) // 2] if damage == "cut" else bytes(len(data)))
    result = case.known()
    assert isinstance(result, Failed) and "has changed since the batch wrote it" in str(
        result.error
    )
    assert case.plan(overwrite=True).todo == [case.job]


def test_a_kill_while_writing_leaves_a_part_that_is_removed(case):
    case.journal.begin(case.job)
    case.part.write_bytes(b"half a video")
    assert case.plan().todo == [case.job]
    assert not case.part.exists()


def test_a_part_that_the_batch_did_not_begin_is_left_alone(case):
    case.part.write_bytes(b"somebody's")
    with pytest.raises(UsageError, match="perhaps from a run that was stopped"):
        case.plan()
    assert case.part.read_bytes() == b"somebody's"


@pytest.mark.parametrize(("before", "strict"), [(None, False), ("old", False), (None, True)])
def test_a_kill_after_the_rename_counts_as_done(case, before, strict):
    case.job = replace(case.job, settings=replace(case.job.settings, strict=strict))
    if before:
        case.output.write_text(before)
    case.journal.begin(case.job)
    process_video(case.job.source, case.output, None, Settings(overwrite=True))
    result = case.known()
    assert isinstance(result, Done) and result.frames == 12
    assert len(result.warnings) == (not strict)
    assert all("is not known" in line and "to paint it anew" in line for line in result.warnings)
    assert case.known() == result  # read from the line that was just added to the journal


def test_failed_work_is_done_again_only_when_asked(case):
    case.journal.begin(case.job)
    error = OutputError("the disk is full")
    case.journal.end(case.job, [Failed(str(case.output), error)])
    result = case.known()
    assert type(result.error) is OutputError and str(result.error) == "the disk is full"
    assert case.plan(retry=True).todo == [case.job]


@pytest.mark.parametrize(
    ("error", "name", "hopeless"),
    [(UsageError, "a.mp4", True), (StrictError, "a.mp4", True), (OutputError, f"{248 * 'x'}.mp4", True),
     (OutputError, "a.mp4", False), (InputError, "a.mp4", False), (WorkerError, "a.mp4", False)],
)  # fmt: skip
def test_failures_of_options_and_of_names_are_hopeless(tmp_path, error, name, hopeless):
    assert is_hopeless(Failed(str(tmp_path / name), error("it failed"))) == hopeless


def test_only_the_looks_that_are_left_are_painted(tmp_path):
    source = make_clip(tmp_path / "in.mp4")
    looks = [JobLook(name, look, str(tmp_path / f"{name}.mp4"))
             for name, look in (("none", BARE), ("red", RED))]  # fmt: skip
    job = Job(str(source), tuple(looks), Settings())
    with Journal(tmp_path / "j.jsonl") as journal:
        journal.begin(job)
        first = job.only({looks[0].output})
        journal.end(first, run_job(first, lambda progress: None))
        plan = plan_batch([job], journal, retry=False, overwrite=False)
    assert [one.looks for one in plan.todo] == [(looks[1],)]
    assert list(plan.known) == [looks[0].output]


def test_no_output_may_replace_an_input_of_another_job(tmp_path):
    one, two = (make_clip(tmp_path / name) for name in ("one.mp4", "two.part.mp4"))
    for output in (one, tmp_path / "two.mp4"):
        jobs = [Job(str(source), (JobLook("x", BARE, str(path)),), Settings())
                for source, path in ((one, tmp_path / "a.mp4"), (two, output))]  # fmt: skip
        with pytest.raises(UsageError, match="which this batch reads"):
            check_inputs_apart(jobs)


def test_a_part_of_other_work_is_not_said_to_be_its_output(case):
    (look,) = case.job.looks
    case.journal.begin(replace(case.job, looks=(replace(look, look=RED),)))
    case.part.write_bytes(b"half")
    with pytest.raises(UsageError, match="perhaps from a run that was stopped") as caught:
        case.plan()
    assert "since the journal" not in str(caught.value)


def test_another_attempt_removes_the_part_of_a_lost_machine(case):
    job = case.journal.begin(case.job)
    case.part.write_bytes(b"half")
    (result,) = do_job(job.again(), lambda progress: None)
    assert isinstance(result, Done) and not case.part.exists()
