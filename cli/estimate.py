"""`makeup-video estimate PHOTO`: the makeup of a photo, as text, as JSON and as a look file."""

import json
from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated, Any

import typer
from makeup_video.cli.console import ResultText, log, print_result, printable
from makeup_video.cli.look_options import faces_meant
from makeup_video.cli.options import FACES, OUTPUT, Debug, Overwrite, PrintJson
from makeup_video.cli.outcome import report_errors

if TYPE_CHECKING:
    from makeup_video.pipeline import Layer
    from makeup_video.pipeline.look.catalogue import Catalogue
    from rich.console import Console

EXAMPLES = (
    "makeup-video estimate look.jpg",
    "makeup-video estimate look.jpg -o look.json",
    "makeup-video estimate look.jpg --catalogue shades.csv",
)
_COLOURFUL = ("256", "truecolor")  # none of 16 colours would be close enough to a lipstick's
_NUMBERS = ("opacity", "gloss", "gloss_roughness", "reflection")  # printed for each layer


def estimate(
    photo: Annotated[str, typer.Argument(metavar="PHOTO", help="A photo of a face with makeup.")],
    ref_face: Annotated[
        str,
        typer.Option(
            metavar="FACE",
            help="Which face to read: largest, or its number as inspect shows it.",
            callback=faces_meant,
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
            help="Name the nearest products of a CSV file: brand, product, shade, hex, optionally "
            "category.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    as_json: PrintJson = False,
    debug: Debug = False,
) -> None:
    """Read the makeup of a photo: colours, finishes, the nearest products."""
    from makeup_video.cli.main import mark_output_whole
    from makeup_video.pipeline.engine.machine import FIND_FACES, check_memory

    check_memory(FIND_FACES)  # with less memory, the libraries of the nets crash while they load
    from makeup_video.pipeline.files.sidecar import LookFile
    from makeup_video.pipeline.look.catalogue import read_catalogue
    from makeup_video.pipeline.look.kinds import KINDS, PARTS
    from makeup_video.pipeline.reference.estimate import estimate_from

    with report_errors("estimate", [output] if output else (), debug):
        shades = None if catalogue is None else read_catalogue(catalogue)
        with ExitStack() as stack:
            file = None
            if output is not None:
                others = [] if catalogue is None else [catalogue]
                file = stack.enter_context(
                    LookFile(output, photo, None, *others, overwrite=overwrite, wanted="photo")
                )
            read = estimate_from(photo, ref_face)
            look = read.look
            if file is not None:
                file.write(look.to_dict())
                mark_output_whole()  # the file is written: Ctrl-C while printing comes too late
        parts = {
            part: _described(look.of(kind.name), part, shades)
            for part, kind in PARTS.items()
            if kind.is_read
        }
        worn = {KINDS[kind].part: round(share, 3) for kind, share in read.worn.items()}
        if as_json:
            values = {part: _for_programs(described) for part, described in parts.items()}
            described = {"photo": photo, "worn": worn, **values}
            print_result(json.dumps(described, indent=2) + "\n")
        else:
            _print(parts, {KINDS[kind].part: read.certainty(kind) for kind in read.worn})
    if output is not None:
        log(f"{output}: look file written")
    if look.is_bare:
        log(f"{photo}: no makeup was found, the look is bare")


def _for_programs(layers: list[dict[str, Any]]) -> dict[str, Any] | None:
    """A part of a look as one JSON object: the first layer, with the others in `more`; None when
    the part is bare."""
    if not layers:
        return None
    return layers[0] | ({"more": layers[1:]} if layers[1:] else {})


def _described(
    layers: "tuple[Layer, ...]", part: str, shades: "Catalogue | None"
) -> list[dict[str, Any]]:
    """The layers of a part as JSON values, each with its place and strength in words."""
    from makeup_video.pipeline.look.finishes import place_in_words

    return [
        _describe(layer, part, shades) | {"place": place_in_words(layer, len(layers) > 1)}
        for layer in layers
    ]


def _describe(layer: "Layer", part: str, shades: "Catalogue | None") -> dict[str, Any]:
    """A layer of makeup as JSON values."""
    from dataclasses import asdict

    from makeup_video.pipeline.look.finishes import in_words
    from makeup_video.pipeline.look.params import hex_of

    params = layer.product
    values: dict[str, Any] = {
        "hex": params.hex,
        "words": in_words(params, part),
        "params": asdict(params),
        "shape": dict(layer.shape),
        "strength": layer.strength,
    }
    if shades is not None:
        values["nearest"] = [
            {
                "ciede2000": round(difference, 2),
                "hex": hex_of(shade.rgb),
                "brand": shade.brand,
                "product": shade.product,
                "shade": shade.shade,
            }
            for difference, shade in shades.nearest(
                (params.red, params.green, params.blue), part=part
            )
        ]
    return values


def _print(parts: dict[str, list[dict[str, Any]]], certainties: dict[str, str]) -> None:
    from rich.console import Console

    text = ResultText()
    console = Console(file=text, highlight=False)
    for part, layers in parts.items():
        if not layers:
            _print_line(console, f"{part}  bare ({certainties[part]})")
        for values in layers:
            _print_layer(console, part, values, certainties[part])
    print_result(text.getvalue())


def _print_layer(console: "Console", part: str, values: dict[str, Any], certainty: str) -> None:
    place = f"{values['place']}; " if values["place"] else ""
    words = f"{values['words']} ({place}{certainty})"
    _print_line(console, f"{part}  {values['hex']}", values["hex"], words)
    numbers = ", ".join(f"{name} {values['params'][name]:.2f}" for name in _NUMBERS)
    _print_line(console, f"      {numbers}")
    if "nearest" not in values:
        return
    none = f"no product in the catalogue is for the {part}"
    _print_line(
        console, f"      {'nearest products, by CIEDE2000:' if values['nearest'] else none}"
    )
    for near in values["nearest"]:
        name = ", ".join(near[part] for part in ("brand", "product", "shade"))
        _print_line(console, f"      {near['ciede2000']:5.1f}  {near['hex']}", near["hex"], name)


def _print_line(console: "Console", head: str, swatch: str | None = None, tail: str = "") -> None:
    """Print one unbroken line, with a patch of the colour `swatch` if the terminal can show it."""
    from rich.text import Text

    line = Text(head)
    if swatch is not None:
        if console.color_system in _COLOURFUL and not console.no_color:
            line.append("  ").append("    ", style=f"on {swatch}")
        line.append(f"  {printable(tail)}")
    console.print(line, soft_wrap=True)
