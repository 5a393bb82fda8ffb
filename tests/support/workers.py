"""A worker for jobs that needs no process of its own, whose start takes longer than most jobs."""

import pickle


class InThisProcess:
    """Does jobs as a process does: with copies, so that what cannot be sent to one fails here."""

    per_machine = None

    def run(self, task, job, report):
        task, job = pickle.loads(pickle.dumps((task, job)))
        return pickle.loads(pickle.dumps(task(job, report)))

    def stop(self):
        pass
