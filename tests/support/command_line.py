"""The command, run in this process or in a process of its own."""

import subprocess
import sys

from makeup_video.cli.app import app
from typer.testing import CliRunner

LIPSTICK = {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6,
            "gloss_roughness": 0.4, "reflection": 0.2}  # fmt: skip
LOOK = {"version": 2, "layers": [{"kind": "lipstick", "product": LIPSTICK}]}


def run(*args):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def command(*args, **options):
    """The real command in its own process."""
    words = [sys.executable, "-m", "makeup_video.cli", *map(str, args)]
    return subprocess.Popen(
        words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        **options,
    )  # fmt: skip
