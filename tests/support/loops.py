"""An event loop for rooms, whose clock the test moves."""


class Loop:
    """An event loop whose clock the test moves; due calls run."""

    def __init__(self):
        self.now, self.calls = 0.0, []

    def time(self):
        return self.now

    def call_at(self, when, call):
        timer = Call(when, call)
        self.calls.append(timer)
        return timer

    def call_later(self, seconds, call):
        return self.call_at(self.now + seconds, call)

    def call_soon_threadsafe(self, call):
        call()

    def run_in_executor(self, pool, call):
        call()

    def go_on(self, seconds):
        self.now += seconds
        due = [call for call in self.calls if call.when <= self.now]
        self.calls = [call for call in self.calls if call.when > self.now]
        for call in due:
            if not call.cancelled:
                call.call()


class Call:
    def __init__(self, when, call):
        self.when, self.call, self.cancelled = when, call, False

    def cancel(self):
        self.cancelled = True
