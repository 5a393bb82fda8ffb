"""`makeup-video doctor`: what this machine has and lacks, to be read or pasted into a report."""

import json
from typing import Annotated

import typer
from makeup_video.cli.console import print_result
from makeup_video.cli.options import RUN, Debug, PrintJson
from makeup_video.cli.outcome import report_errors

EXAMPLES = ("makeup-video doctor", "makeup-video doctor --json")


def doctor(
    device: Annotated[
        str,
        typer.Option(
            metavar="DEVICE",
            help="The OpenCL device to test: its number or part of its name; default: the CPU.",
            rich_help_panel=RUN,
        ),
    ] = "",
    as_json: PrintJson = False,
    debug: Debug = False,
) -> None:
    """Test this machine for a few seconds: versions, devices, speed, what is wrong."""
    from dataclasses import asdict

    from makeup_video.cli.findings import BAD, findings

    found = []
    with report_errors("doctor", debug=debug):
        for finding in findings(device):
            found.append(finding)
            if not as_json:
                print_result(f"{finding.state:4}  {finding.what}: {finding.words}\n")
    if as_json:
        print_result(json.dumps([asdict(finding) for finding in found], indent=2) + "\n")
    if any(finding.state == BAD for finding in found):
        raise typer.Exit(1)
