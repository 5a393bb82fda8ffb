"""`makeup-video looks`: the looks that come with the package."""

import json
from typing import Annotated

import typer
from makeup_video.cli.console import log, print_result
from makeup_video.cli.options import OUTPUT, Debug, Overwrite, PrintJson
from makeup_video.cli.outcome import report_errors

EXAMPLES = (
    "makeup-video looks",
    "makeup-video looks cat-eye -o mine.json",
)


def looks(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="The look to print; default: a list.")
    ] = None,
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="Write the look file, to edit and to use with --look.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    overwrite: Overwrite = False,
    as_json: PrintJson = False,
    debug: Debug = False,
) -> None:
    """List the ready looks, or print one of them as a look file."""
    from makeup_video.pipeline import UsageError
    from makeup_video.pipeline.look.ready import ready_look
    from makeup_video.pipeline.look.strict_json import written

    with report_errors("looks", [output] if output else (), debug):
        if name is None:
            if output is not None:
                raise UsageError("-o writes one look: add its NAME, or leave -o out")
            print_result(_list(as_json))
            return
        ready = ready_look(name)
        if output is None:
            print_result(written(ready.look.to_dict()))
            return
        from makeup_video.pipeline.files.sidecar import LookFile

        with LookFile(output, ready.path, None, overwrite=overwrite) as file:
            file.write(ready.look.to_dict())
    log(f"{output}: look file written")


def _list(as_json: bool) -> str:
    """The names and descriptions of the ready looks, in lines or as JSON."""
    from makeup_video.pipeline import ready_looks

    ready = ready_looks()
    if as_json:
        return json.dumps([one.to_dict() for one in ready], indent=2) + "\n"
    width = max(len(one.name) for one in ready)
    return "".join(f"{one.name:{width}}  {one.words}\n" for one in ready)
