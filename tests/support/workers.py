"""A worker for jobs that needs no process of its own, whose start takes longer than most jobs."""

import pickle

import pytest
from command_line import run
from makeup_video.pipeline.batch import run as batch_run


class InThisProcess:
    """Does jobs on copies, as a process does: objects that cannot be sent to one fail here, too."""

    per_machine = None

    def run(self, task, job, report):
        task, job = pickle.loads(pickle.dumps((task, job)))
        return pickle.loads(pickle.dumps(task(job, report)))

    def stop(self):
        pass


def run_here(*words):
    """Run the command, with its jobs in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch_run, "local_workers", lambda count: [InThisProcess()])
        return run(*words)
