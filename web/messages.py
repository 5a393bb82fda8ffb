"""The messages of pages and server: JSON objects with a "type".

page -> server
    look     {look, n}         the whole look; n counts this page's own looks. A look from a file
                               has no n, since the file may be of any version: the server returns
                               the look as this version writes it, with its defaults filled in
    compare  {on}              whether pictures without makeup are needed
    shown    {pts_us}          this picture is on the screen
    video    {on}              whether the page wants H.264 instead of JPEG
server -> page
    hello    {mode, session, look, photo, finishes, parameters, kinds, photo_bytes_limit, has_video}
                               photo: {name, look, words}, the last photo that was read and its look
                               in words, or null; has_video: whether H.264 is available, too
    look     {look, photo, seen}
                               photo: the photo that the look has just been read from, or null
                               seen: the newest n that had arrived from this page, or null; a page
                               that has sent a newer look since then keeps that look
    seen     {seen}            sent instead of a look message to the page whose own look is painted.
                               A look that neither message confirms may be lost
    camera   {}                another camera or size is in use: see /camera
    figures  {fps, ..., viewers, screen_ms}
    error    {text}
    bye      {}                the server stops
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from makeup_video.pipeline.errors import LookError, UsageError
from makeup_video.pipeline.look.finishes import FINISHES
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import Kind
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.look.strict_json import object_without_repeats, whole_number
from makeup_video.web.session import PHOTO_BYTES, PhotoLook, Session

_LARGEST = 2**63
# How the page draws a product, by the region that it is worn on; in other regions as a powder.
# Lines are drawn as a line in every region.
_SWATCHES = {"lips": "stroke", "face": "flush"}


@dataclass(frozen=True, slots=True)
class LookRequest:
    """A look that a page wants. It is read only when it is painted, as a newer one may replace it.

    values: the look as it arrived.  n: the count of the page's newest look.  is_counted: False for
    a look from a file.
    """

    values: Any
    n: int | None
    is_counted: bool

    @property
    def look(self) -> Look:
        """The look that `values` describe. Raises LookError when they do not describe a look."""
        return Look.from_dict(self.values)

    def after(self, older: "LookRequest | None") -> "LookRequest":
        """This request in place of an older one, whose count it takes over if it has none."""
        if older is None or self.n is not None:
            return self
        return LookRequest(self.values, older.n, self.is_counted)


@dataclass(frozen=True, slots=True)
class CompareRequest:
    """A page starts or stops comparing."""

    on: bool


@dataclass(frozen=True, slots=True)
class PictureShown:
    """A picture is on the page's screen."""

    pts_us: int


@dataclass(frozen=True, slots=True)
class VideoRequest:
    """A page wants H.264 or, if not `on`, JPEG from now on."""

    on: bool


PageMessage = LookRequest | CompareRequest | PictureShown | VideoRequest


def read_message(text: str) -> PageMessage:
    """Parse a page's message. A look in it is not read yet.

    Raises LookError or UsageError: one line, for the page.
    """
    try:
        values = json.loads(
            text,
            object_pairs_hook=object_without_repeats,
            parse_constant=_refuse,
            parse_int=whole_number,
        )
    except LookError:
        raise
    except (ValueError, RecursionError):
        raise UsageError("a message must be a JSON object without NaN or Infinity") from None
    kind = values.get("type") if isinstance(values, dict) else None
    if kind == "look":
        n = _counted(values)
        return LookRequest(values.get("look"), n, n is not None)
    if kind == "compare" and isinstance(values.get("on"), bool):
        return CompareRequest(values["on"])
    if kind == "video" and isinstance(values.get("on"), bool):
        return VideoRequest(values["on"])
    if kind == "shown" and _is_count(values.get("pts_us")):
        return PictureShown(values["pts_us"])
    raise UsageError(
        'a message must be {"type": "look", "look": {...}}, {"type": "compare" or "video", '
        '"on": true or false} or {"type": "shown", "pts_us": whole number}'
    )


def hello(mode: str, session: Session) -> str:
    """Write the first message of a connection."""
    photo = session.photo
    return json.dumps(
        {
            "type": "hello",
            "mode": mode,
            "session": session.name,
            "look": session.look.to_dict(),
            "photo": None if photo is None else _photo(photo),
            "finishes": FINISHES,
            "parameters": parameters(),
            "kinds": [_kind(kind) for kind in KINDS.values()],
            "photo_bytes_limit": PHOTO_BYTES,
            "has_video": session.has_video,
        }
    )


def _kind(kind: Kind) -> dict[str, Any]:
    """The values from which the page makes the controls of a kind of makeup.

    order: the place in the order of painting, as in a look's layers.  slots: the whole shape of
    each slot, by name.
    """
    red, green, blue = kind.first_rgb
    return {
        "name": kind.name,
        "part": kind.part,
        "title": kind.title,
        "product": kind.product,
        "first": {"red": red, "green": green, "blue": blue},
        "first_finish": kind.first_finish,
        "most": kind.most,
        "order": kind.order,
        "swatch": "line" if kind.is_line else _SWATCHES.get(kind.region, "powder"),
        "slots": {name: kind.whole_shape({"slot": name}) for name in kind.slots},
        "dials": [
            {
                "name": dial.name,
                "title": dial.title,
                "help": dial.meaning,
                "choices": dial.choices,
                "low": dial.low,
                "high": dial.high,
                "default": dial.default,
                "unit": dial.unit,
                "is_colour": dial.is_colour,
                "is_map": dial.is_map,
            }
            for dial in kind.dials
        ],
    }


def look_message(look: Look, photo: PhotoLook | None, seen: int | None) -> str:
    """Write a look message.  photo: the photo that the look has just been read from."""
    source = None if photo is None else _photo(photo)
    return json.dumps({"type": "look", "look": look.to_dict(), "photo": source, "seen": seen})


def seen_message(seen: int | None) -> str:
    """Confirm to a page that its look has arrived."""
    return json.dumps({"type": "seen", "seen": seen})


def _photo(photo: PhotoLook) -> dict[str, Any]:
    return {"name": photo.name, "look": photo.look.to_dict(), "words": photo.words}


def figures_message(values: Mapping[str, Any], viewers: int, screen_ms: float | None) -> str:
    return json.dumps(
        {"type": "figures", **values, "viewers": viewers, "screen_ms": screen_ms}, default=str
    )


def error_message(text: str) -> str:
    return json.dumps({"type": "error", "text": text})


CAMERA = json.dumps({"type": "camera"})
BYE = json.dumps({"type": "bye"})


def _refuse(name: str) -> None:
    raise LookError(f"a look must not contain {name}")


def _counted(values: Mapping[str, Any]) -> int | None:
    n = values.get("n")
    if n is not None and not _is_count(n):
        raise UsageError("n counts the looks of a page: give a whole number, or leave it out")
    return n


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < _LARGEST


_LABELS = {
    "red": "Red",
    "green": "Green",
    "blue": "Blue",
    "opacity": "Opacity",
    "gloss": "Gloss",
    "gloss_roughness": "Softness of shine",
    "reflection": "Reflection",
    "edge_softness": "Soft edge",
    "texture_keep": "Fine lines",
    "undertone": "Own skin tone",
    "gloss_detail": "Shine of the skin",
    "fresnel": "Bright edges",
    "environment_blur": "Blur of reflection",
    "shimmer": "Sparkles",
    "shimmer_size": "Size of sparkles",
    "shimmer_tint": "Colour of sparkles",
    "light_adaptation": "Takes on the light",
}
_MOST = 4.0  # the end of sliders whose parameter has no limit; gloss then looks like lacquer


def parameters() -> list[dict[str, Any]]:
    """Describe all 17 parameters, in the order of a look file, for the page's sliders."""
    return [
        {
            "name": spec.name,
            "low": spec.metadata["low"],
            "high": min(spec.metadata["high"], 255 if spec.metadata["high"] == 255 else _MOST),
            "step": 1 if spec.metadata["high"] == 255 else 0.01,
            "label": _LABELS[spec.name],
            "help": spec.metadata["meaning"],
        }
        for spec in fields(GraphicsParams)
    ]
