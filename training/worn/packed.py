"""Files of packed crops, as the nets that read a form of makeup learn from them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np


def save_crops(path: Path, painted: Sequence[Any], real: Sequence[Any]) -> None:
    """Write named tuples of one kind, a field each, and is_real; the painted ones come first."""
    fields = (painted or real)[0]._fields
    packed = [np.stack(each) for each in zip(*painted, *real, strict=True)]
    is_real = np.arange(len(painted) + len(real)) >= len(painted)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **dict(zip(fields, packed, strict=True)), is_real=is_real)
