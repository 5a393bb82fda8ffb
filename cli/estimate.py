"""`makeup-video estimate PHOTO`: what is read from a photo, for people, programs and look files."""

import io
import json
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated, Any

import typer
from makeup_video.cli.console import printable, put, say
from makeup_video.cli.outcome import told_in_one_line

if TYPE_CHECKING:
    from makeup_video.pipeline import GraphicsParams
    from makeup_video.pipeline.look.catalogue import Catalogue
    from rich.console import Console

_COLOURFUL = ("256", "truecolor")  # of 16 colours none is near enough to a lipstick's
_SHOWN = ("opacity", "gloss", "gloss_roughness", "reflection")


def estimate(
    photo: Annotated[str, typer.Argument(metavar="PHOTO", help="Somebody who wears makeup.")],
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="Write the look as JSON.")
    ] = None,
    ref_face: Annotated[
        str, typer.Option(help="largest, or a face's number as inspect shows it.")
    ] = "",
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="CSV",
            help="Products (brand, product, shade, hex, maybe category): name the nearest.",
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    overwrite: Annotated[bool, typer.Option("-y", "--yes", help="Overwrite FILE.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Read the makeup of a photo: colours, finishes, the nearest products."""
    from makeup_video.cli.main import nothing_is_left_to_stop
    from makeup_video.pipeline import look_from_photo
    from makeup_video.pipeline.look.catalogue import read_catalogue
    from makeup_video.pipeline.look.regions import REGIONS
    from makeup_video.pipeline.media.sidecar import LookFile

    with told_in_one_line(output, debug):
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
                nothing_is_left_to_stop()  # what is printed now follows the file
        regions = {name: _told(name, getattr(look, name), shades) for name in REGIONS}
        if as_json:
            put(json.dumps({"photo": photo, **regions}, indent=2) + "\n")
        else:
            _print(regions)
    if look.is_bare:
        say(f"{photo}: no makeup was found, the look is bare")


def _told(
    region: str, params: "GraphicsParams | None", shades: "Catalogue | None"
) -> dict[str, Any] | None:
    """All that is said of a region; None when it is bare."""
    from dataclasses import asdict

    from makeup_video.pipeline.look.finishes import in_words

    if params is None:
        return None
    told: dict[str, Any] = {
        "hex": params.hex,
        "words": in_words(params, region),
        "params": asdict(params),
    }
    if shades is not None:
        told["nearest"] = [
            {
                "ciede2000": round(off, 2),
                "hex": "#" + bytes(one.rgb).hex().upper(),
                "brand": one.brand,
                "product": one.product,
                "shade": one.shade,
            }
            for off, one in shades.nearest((params.red, params.green, params.blue), region=region)
        ]
    return told


def _print(regions: dict[str, dict[str, Any] | None]) -> None:
    from rich.console import Console

    text = io.StringIO()
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    console = Console(file=text, force_terminal=is_terminal or None, highlight=False)
    _print_regions(console, regions)
    put(text.getvalue())


def _print_regions(console: "Console", regions: dict[str, dict[str, Any] | None]) -> None:
    for region, one in regions.items():
        if one is None:
            _print_line(console, f"{region}  bare")
            continue
        _print_line(console, f"{region}  {one['hex']}", one["hex"], one["words"])
        numbers = ", ".join(f"{name} {one['params'][name]:.2f}" for name in _SHOWN)
        _print_line(console, f"      {numbers}")
        if "nearest" in one:
            none = f"no product in the catalogue is for the {region}"
            _print_line(
                console, f"      {'nearest products, by CIEDE2000:' if one['nearest'] else none}"
            )
        for near in one.get("nearest", []):
            name = ", ".join(near[part] for part in ("brand", "product", "shade"))
            _print_line(
                console, f"      {near['ciede2000']:5.1f}  {near['hex']}", near["hex"], name
            )


def _print_line(console: "Console", head: str, swatch: str | None = None, tail: str = "") -> None:
    """One line, however long; with a patch of the colour where a terminal has enough of them."""
    from rich.text import Text

    line = Text(head)
    if swatch is not None:
        if console.color_system in _COLOURFUL and not console.no_color:
            line.append("  ").append("    ", style=f"on {swatch}")
        line.append(f"  {printable(tail)}")
    console.print(line, soft_wrap=True)
