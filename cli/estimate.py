"""`makeup-video estimate PHOTO`: the makeup of a photo, as text, as JSON and as a look file."""

import io
import json
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated, Any

import typer
from makeup_video.cli.console import log, print_result, printable
from makeup_video.cli.options import FACES, OUTPUT, Debug, Overwrite, PrintJson
from makeup_video.cli.outcome import report_errors

if TYPE_CHECKING:
    from makeup_video.pipeline import GraphicsParams
    from makeup_video.pipeline.look.catalogue import Catalogue
    from rich.console import Console

EXAMPLES = (
    "makeup-video estimate look.jpg",
    "makeup-video estimate look.jpg -o look.json",
    "makeup-video estimate look.jpg --catalogue shades.csv",
)
_COLOURFUL = ("256", "truecolor")  # of 16 colours none is near enough to a lipstick's
_NUMBERS = ("opacity", "gloss", "gloss_roughness", "reflection")  # printed of each region


def estimate(
    photo: Annotated[str, typer.Argument(metavar="PHOTO", help="Somebody who wears makeup.")],
    ref_face: Annotated[
        str,
        typer.Option(
            metavar="FACE",
            help="Whose makeup: largest, or a face's number as inspect shows it.",
            rich_help_panel=FACES,
        ),
    ] = "",
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="Write the look as JSON.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    overwrite: Overwrite = False,
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="CSV",
            help="Name the nearest products: brand, product, shade, hex, maybe category.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    as_json: PrintJson = False,
    debug: Debug = False,
) -> None:
    """Read the makeup of a photo: colours, finishes, the nearest products."""
    from makeup_video.cli.main import mark_output_whole
    from makeup_video.pipeline import look_from_photo
    from makeup_video.pipeline.look.catalogue import read_catalogue
    from makeup_video.pipeline.look.regions import REGIONS
    from makeup_video.pipeline.media.sidecar import LookFile

    with report_errors("estimate", output, debug):
        shades = None if catalogue is None else read_catalogue(catalogue)
        with ExitStack() as stack:
            file = None
            if output is not None:
                others = [] if catalogue is None else [catalogue]
                file = stack.enter_context(
                    LookFile(output, photo, None, *others, overwrite=overwrite)
                )
            look = look_from_photo(photo, ref_face)
            if file is not None:
                file.write(look.to_dict())
                mark_output_whole()  # what is printed now follows the file
        regions = {name: _describe(name, getattr(look, name), shades) for name in REGIONS}
        if as_json:
            print_result(json.dumps({"photo": photo, **regions}, indent=2) + "\n")
        else:
            _print(regions)
    if look.is_bare:
        log(f"{photo}: no makeup was found, the look is bare")


def _describe(
    region: str, params: "GraphicsParams | None", shades: "Catalogue | None"
) -> dict[str, Any] | None:
    """The makeup of a region as JSON values; None when the region is bare."""
    from dataclasses import asdict

    from makeup_video.pipeline.look.finishes import in_words

    if params is None:
        return None
    values: dict[str, Any] = {
        "hex": params.hex,
        "words": in_words(params, region),
        "params": asdict(params),
    }
    if shades is not None:
        values["nearest"] = [
            {
                "ciede2000": round(difference, 2),
                "hex": "#" + bytes(shade.rgb).hex().upper(),
                "brand": shade.brand,
                "product": shade.product,
                "shade": shade.shade,
            }
            for difference, shade in shades.nearest(
                (params.red, params.green, params.blue), region=region
            )
        ]
    return values


def _print(regions: dict[str, dict[str, Any] | None]) -> None:
    from rich.console import Console

    text = io.StringIO()
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    console = Console(file=text, force_terminal=is_terminal or None, highlight=False)
    _print_regions(console, regions)
    print_result(text.getvalue())


def _print_regions(console: "Console", regions: dict[str, dict[str, Any] | None]) -> None:
    for region, values in regions.items():
        if values is None:
            _print_line(console, f"{region}  bare")
            continue
        _print_line(console, f"{region}  {values['hex']}", values["hex"], values["words"])
        numbers = ", ".join(f"{name} {values['params'][name]:.2f}" for name in _NUMBERS)
        _print_line(console, f"      {numbers}")
        if "nearest" in values:
            none = f"no product in the catalogue is for the {region}"
            _print_line(
                console, f"      {'nearest products, by CIEDE2000:' if values['nearest'] else none}"
            )
        for near in values.get("nearest", []):
            name = ", ".join(near[part] for part in ("brand", "product", "shade"))
            _print_line(
                console, f"      {near['ciede2000']:5.1f}  {near['hex']}", near["hex"], name
            )


def _print_line(console: "Console", head: str, swatch: str | None = None, tail: str = "") -> None:
    """Print one line, never broken; a terminal with enough colours shows a patch of the swatch."""
    from rich.text import Text

    line = Text(head)
    if swatch is not None:
        if console.color_system in _COLOURFUL and not console.no_color:
            line.append("  ").append("    ", style=f"on {swatch}")
        line.append(f"  {printable(tail)}")
    console.print(line, soft_wrap=True)
