"""Jobs on copies of their files: the results carry the names of the original job."""

import pytest
from makeup_video.pipeline import Look, Settings, UsageError
from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook


def job_of(*outputs):
    return Job("in.mp4", tuple(JobLook("x", Look(), one) for one in outputs), Settings())


@pytest.mark.parametrize(
    "elsewhere", [Job.at_full_paths, lambda job: job.moved("/there/in.mp4", ["/0/a", "/1/b"])]
)
def test_results_on_other_files_are_named_as_the_jobs_own(elsewhere):
    job, error = job_of("a.mp4", "b.mp4"), UsageError("no")
    failed, done = elsewhere(job).outputs
    assert (failed, done) != job.outputs
    results = [Failed(failed, error), Done(done, 9, 1, 0.5, (), False, None, None)]
    named, whole = job.brought_back(results)
    assert named == [Failed("a.mp4", error), results[1]._replace(output="b.mp4")]
    assert whole == [1]
