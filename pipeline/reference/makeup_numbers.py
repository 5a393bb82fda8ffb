"""Output of the net that reads which makeup is worn: a look as a vector.

Every slot of eyeshadow and every other kind has fixed places in the vector, so the order of a
look's layers never matters. Its numbers are opacity and colour, then dials of the kind.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import Dial
from makeup_video.pipeline.look.look import Layer, Look

# The kinds that are read, in the order of the net's log-odds.
WORN = tuple(kind.name for kind in KINDS.values() if kind.is_read)
# The layers that the vector holds: kind, slot (or ""), and the dials that are read. The dials of
# eyeliner and lipstick only help the net to learn: for looks, read_liner.py, lower_line.py and
# read_lipstick.py read them.
LAYERS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("eyeshadow", "lid", ()),
    ("eyeshadow", "crease", ()),
    ("eyeshadow", "outer", ()),
    ("eyeshadow", "under", ()),
    ("eyeshadow", "inner", ()),
    ("eyeshadow", "brow_bone", ()),
    ("eyeliner", "", ("thickness", "wing", "wing_angle", "lower")),
    ("blush", "", ("height", "reach", "size", "across")),
    ("lipstick", "", ("gradient",)),
)
COUNT = sum(4 + len(dials) for *_, dials in LAYERS)


@dataclass(frozen=True, slots=True)
class ReadLayer:
    """A layer as the net reads it.

    opacity: the product's opacity times the layer's strength; 0 for a layer that is not worn.
    rgb: R'G'B' codes 0..255.  shape: values of dials by name.
    """

    kind: str
    slot: str
    opacity: float
    rgb: tuple[float, float, float]
    shape: Mapping[str, float]


def to_vector(look: Look) -> tuple[np.ndarray, np.ndarray]:
    """The vector of a look, (COUNT,) float32 of about 0..1, and a weight for each number.

    The weight of a colour or a dial is the opacity of its layer, so a layer that is not worn has no
    weight. The weight of an opacity is 1.
    """
    vector, weights = [], []
    for kind, slot, dials in LAYERS:
        layer = _layer_of(look, kind, slot)
        opacity = layer.product.opacity * layer.strength * look.strength if layer else 0.0
        numbers = [0.0] * (3 + len(dials))
        if layer is not None:
            shape, worn = layer.whole_shape, layer.product
            numbers[:3] = [code / 255 for code in (worn.red, worn.green, worn.blue)]
            for at, dial in enumerate(_dials(kind, dials), 3):
                numbers[at] = (shape[dial.name] - dial.low) / (dial.high - dial.low)
        vector += [opacity, *numbers]
        weights += [1.0] + [opacity] * len(numbers)
    return np.array(vector, np.float32), np.array(weights, np.float32)


def from_vector(vector: np.ndarray) -> list[ReadLayer]:
    """The layers that a vector describes, in the order of LAYERS, including those not worn."""
    read, values = [], iter(np.clip(np.asarray(vector, np.float64), 0, 1).tolist())
    for kind, slot, dials in LAYERS:
        opacity, red, green, blue = (next(values) for _ in range(4))
        shape = {
            dial.name: round(dial.low + next(values) * (dial.high - dial.low), 3)
            for dial in _dials(kind, dials)
        }
        read.append(ReadLayer(kind, slot, opacity, (255 * red, 255 * green, 255 * blue), shape))
    return read


def _layer_of(look: Look, kind: str, slot: str) -> Layer | None:
    for layer in look.of(kind):
        if not slot or layer.whole_shape["slot"] == slot:
            return layer
    return None


def _dials(kind: str, names: Sequence[str]) -> list[Dial]:
    return [dial for name in names for dial in KINDS[kind].dials if dial.name == name]
