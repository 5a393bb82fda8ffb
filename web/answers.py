"""The JSON texts that the server answers with, and the look that it reads from a request's body."""

import base64
import json
from collections.abc import Iterable
from typing import Any

from makeup_video.pipeline.errors import CatalogueError, LookError
from makeup_video.pipeline.look.catalogue import rows_in
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import hex_of
from makeup_video.pipeline.look.ready import ReadyLook
from makeup_video.pipeline.look.strict_json import read_json
from makeup_video.web.session import SeveralFaces
from makeup_video.web.upload import without_controls

MOST_SHADES = 2000  # of a catalogue on the page; a browser stores at most 5 MB for a site


def ready_looks_message(looks: Iterable[ReadyLook]) -> str:
    """Write the answer of /looks: a list of objects with `name`, `words` and `look`."""
    return json.dumps([one.to_dict() for one in looks])


def several_faces_message(name: str, photo: SeveralFaces) -> str:
    """Write the answer of /photo where a face must be chosen.

    Its fields are `error`, `picture` (a JPEG in Base64) and `faces`: objects with `number`, `left`,
    `top`, `width` and `height`, the last four as shares of the picture.
    """
    keys = "left", "top", "width", "height"
    return json.dumps(
        {
            "error": f"{name} shows {len(photo.boxes)} faces: choose one",
            "picture": base64.b64encode(photo.picture).decode(),
            "faces": [
                {"number": number, **dict(zip(keys, box, strict=True))}
                for number, box in photo.boxes.items()
            ],
        }
    )


def shades_message(name: str, data: bytes) -> str:
    """Write the answer of /shades: {name, shades}, where each shade has `title`, `hex` and `parts`.

    Raises CatalogueError, which names the file, the line and the fault.
    """
    shades: list[dict[str, Any]] = []
    for row in rows_in(data, name):
        one = row.shade
        if len(shades) == MOST_SHADES:
            raise CatalogueError(
                f"{name} has more than {MOST_SHADES} shades, the most that this page shows: "
                "give one with fewer"
            )
        title = without_controls(" ".join(f"{one.brand} {one.product} {one.shade}".split()))
        shades.append({"title": title, "hex": hex_of(one.rgb), "parts": one.parts})
    if not shades:
        raise CatalogueError(f"{name} has no rows: a catalogue needs at least one product")
    return json.dumps({"name": name, "shades": shades})


def look_in(data: bytes) -> Look:
    """Read the look in a request's body. Raises LookError."""
    try:
        return Look.from_dict(read_json(data.decode()))
    except UnicodeDecodeError as error:
        raise LookError("a look must be a JSON object, got bytes that are not text") from error
