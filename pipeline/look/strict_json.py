"""Look files as JSON, read strictly."""

import json
from typing import Any

from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.params import shown

_MOST_DIGITS = 400  # no number in range has more, and Python reads no more than 4300


def read_json(text: str) -> Any:
    """The values in a JSON text. Raises LookError, one line, for text that is not JSON and for a
    key that is given twice."""
    try:
        return json.loads(text, object_pairs_hook=object_without_repeats, parse_int=whole_number)
    except json.JSONDecodeError as error:
        raise LookError(
            f"not JSON at line {error.lineno}, column {error.colno}: {error.msg}"
        ) from error
    except RecursionError as error:
        raise LookError("a look is a JSON object, this nests too deep") from error


def written(values: dict[str, Any]) -> str:
    """The text of a look file."""
    return json.dumps(values, indent=2) + "\n"


def whole_number(digits: str) -> int | float:
    """A whole number of JSON; infinite when it has more digits than any number in range."""
    return int(digits) if len(digits) <= _MOST_DIGITS else float(digits)


def object_without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The object_pairs_hook of json.loads. Raises LookError for a key that is given twice."""
    values: dict[str, Any] = {}
    for key, value in pairs:
        if key in values:
            raise LookError(f"{shown(key, repr)} is given twice: keep one")
        values[key] = value
    return values
