"""What holds for all tests."""

import signal

# A job in the background may be started with Ctrl-C ignored, and would hand that on: the tests of
# Ctrl-C would then wait for ever.
signal.signal(signal.SIGINT, signal.default_int_handler)
