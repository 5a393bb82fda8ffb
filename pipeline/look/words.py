"""The words that people use for colours, finishes, parts, zones and shares, and what they mean.

Neither case nor spaces, hyphens and underscores within a word matter: "Brow bone" is `brow_bone`.
"""

import re
from collections.abc import Iterable, Mapping

from makeup_video.pipeline.errors import closest
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.kinds.kind import Kind
from makeup_video.pipeline.look.params import rgb_of_hex

_BEGINS = 3  # letters from which on a word may stand for the only name that begins with it
_NUMBER = re.compile(r"([+-]?(?:\d{1,9}\.?\d{0,9}|\.\d{1,9}))\s*(%?)", re.ASCII)
NONE = "none"

FINISH_WORDS: Mapping[str, tuple[str, ...]] = {
    "matte": ("matt", "mat", "flat", "velvet", "velvety", "powder", "powdery"),
    "satin": ("satiny", "natural", "cream", "creamy", "silk", "silky", "semi matte", "demi matte"),
    "sheer": ("tint", "tinted", "stain", "balm", "translucent", "transparent"),
    "gloss": ("glossy", "shiny", "shine", "wet", "lacquer", "vinyl", "glass", "patent"),
    "metallic": ("metal", "foil", "foiled", "chrome"),
    "shimmer": (
        "shimmery", "shimmering", "glitter", "glittery", "sparkle", "sparkly", "pearl", "pearly",
        "frost", "frosted", "frosty",
    ),
}  # fmt: skip

# Colours that people call by the names of shades, which CSS does not have. Each is the median of
# the lipsticks in a table whose shade has that word; taupe is the median of the eyeshadows
# (training/shade_names.py).
SHADES: Mapping[str, str] = {
    "apricot": "#E1A29D", "berry": "#9D354F", "bordeaux": "#731D37", "caramel": "#B2625E",
    "cherry": "#962629", "coffee": "#803231", "grape": "#91325B", "lilac": "#B27DB0",
    "mauve": "#B6697A", "melon": "#F45C5F", "merlot": "#8F212E", "nude": "#BD766B",
    "peach": "#EF7563", "poppy": "#EE4140", "raspberry": "#963950", "rose": "#D05D66",
    "ruby": "#A81D38", "strawberry": "#DC4C6F", "tangerine": "#FC7C48", "taupe": "#A6887E",
    "watermelon": "#D65E78", "wine": "#92273A",
}  # fmt: skip


def plain(word: str) -> str:
    """A word in lower case, without spaces, hyphens and underscores: "Brow-Bone " is "browbone"."""
    return re.sub(r"[\s_-]+", "", word).lower()


def is_none(word: str) -> bool:
    """Whether a word means that nothing is painted."""
    return plain(word) in (NONE, "bare", "off")


def rgb_of(text: str) -> tuple[int, int, int] | None:
    """Red, green, blue, sRGB code values 0..255; None for a text that is no colour.

    text: hex digits with or without a #, a name of CSS or of SHADES, or CSS's rgb(...) or hsl(...).
    """
    rgb = rgb_of_hex(SHADES.get(plain(text), text.strip()))
    if rgb is not None:
        return rgb
    from PIL import ImageColor  # 20 ms that hex digits need not wait for

    try:
        red, green, blue, *alpha = ImageColor.getrgb(text.strip() if "(" in text else plain(text))
    except ValueError:
        return None
    if alpha or not 0 <= min(red, green, blue) <= max(red, green, blue) <= 255:
        return None
    return red, green, blue


def like_a_colour(text: str) -> str:
    """ ": did you mean darkred?" for a mistyped name of a colour, else nothing."""
    from PIL import ImageColor

    return did_you_mean(text, [*ImageColor.colormap, *SHADES])


def finish_of(word: str) -> str | None:
    """The finish that a word names."""
    return _known(word, {name: (name, *others) for name, others in FINISH_WORDS.items()})


def part_of(word: str) -> str | None:
    """The part of a look that a word names."""
    return _known(word, {part: _words_of(kind) for part, kind in PARTS.items()})


def slot_named(word: str, kind: Kind) -> str | None:
    """The slot of a kind that a word names."""
    return _known(word, {slot: (slot, *kind.slot_words.get(slot, ())) for slot in kind.slots})


def number_of(text: str) -> float | None:
    """A number from "0.8" or "80%"; None for any other text."""
    found = _NUMBER.fullmatch(text.strip())
    if found is None:
        return None
    return float(found[1]) / (100 if found[2] else 1)


def did_you_mean(word: str, names: Iterable[str]) -> str:
    """ ": did you mean gloss?" where a name is close to a word, else nothing."""
    by_plain: dict[str, str] = {}
    for name in names:
        by_plain.setdefault(plain(name), name)
    wanted = plain(word)
    meant = closest(wanted, by_plain)
    if meant is None and len(wanted) >= _BEGINS:
        begun = [name for name in by_plain if name.startswith(wanted)]
        if len(begun) == 1:  # "cat" is cat-eye, but "dark" may be any of many
            meant = begun[0]
    return f": did you mean {by_plain[meant]}?" if meant is not None else ""


def finish_names() -> list[str]:
    """Every word for a finish."""
    return [word for name, others in FINISH_WORDS.items() for word in (name, *others)]


def part_names() -> list[str]:
    """Every word for a part."""
    return [word for kind in PARTS.values() for word in _words_of(kind)]


def _words_of(kind: Kind) -> tuple[str, ...]:
    return kind.part, kind.name, kind.title, kind.product, *kind.words


def _known(word: str, table: Mapping[str, Iterable[str]]) -> str | None:
    """The row of a table that has a word; names of rows come before other words."""
    wanted = plain(word)
    for name in table:
        if plain(name) == wanted:
            return name
    return next((name for name, words in table.items() if wanted in map(plain, words)), None)
