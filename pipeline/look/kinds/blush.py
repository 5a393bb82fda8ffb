"""Blush: a soft flush on the cheeks, which may reach the temples or cross the nose."""

from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind, Shape
from makeup_video.pipeline.look.kinds.ramps import faded, stroke
from makeup_video.pipeline.look.params import GraphicsParams

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.30, 0.00, 0.95, 0.00, 0.80, 1.00, 0.00, 0.50, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.28, 0.12, 0.80, 0.00, 0.80, 1.00, 0.05, 0.80, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.16, 0.05, 0.80, 0.00, 0.80, 1.00, 0.08, 0.80, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.26, 0.60, 0.50, 0.05, 0.80, 1.00, 0.08, 0.70, 0.50, 0.60, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.32, 0.50, 0.65, 0.05, 0.80, 0.90, 0.05, 0.60, 0.50, 0.60, 0.40, 0.10, 1.00, 1.0),
    "shimmer":  (0.29, 0.30, 0.70, 0.02, 0.80, 0.95, 0.05, 0.60, 0.40, 0.60, 0.45, 0.10, 0.70, 1.0),
}  # fmt: skip
# In distances of the outer eye corners, for the cheek at the picture's right: apple, highest place
# on the cheekbone, temple, and the middle of the nose.
_APPLE, _CHEEKBONE, _TEMPLE, _NOSE = (0.43, 0.38), (0.57, 0.25), (0.76, 0.11), (0.0, 0.22)
_BEYOND = 0.3  # how far a stroke fades beyond its half width


def _coats(at: FaceFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """A stroke on each cheek that fades in all directions, and one over the nose."""
    import numpy as np

    beside = np.abs(at.across)
    start = _between(_APPLE, _CHEEKBONE, shape["height"])
    end = _between(start, _TEMPLE, shape["reach"])
    radius = 0.12 + 0.22 * shape["size"]
    soft = faded(0.25 + 0.75 * shape["softness"], product)
    density = stroke(beside, at.down, (start, end), radius, soft, _BEYOND)
    if shape["across"] > 0:
        band = stroke(beside, at.down, (_NOSE, start), 0.65 * radius, soft, _BEYOND)
        density = np.maximum(density, shape["across"] * band)
    return [Coat(product, density.astype(np.float32))]


def _between(a: tuple[float, float], b: tuple[float, float], share: float) -> tuple[float, float]:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


KIND = Kind(
    name="blush",
    part="blush",
    title="Blush",
    product="Blush",
    words=("blusher", "rouge", "cheek", "cheeks"),
    must_see="cheeks",
    category=r"(?<![a-z])(blush|cheek|rouge)",
    first_rgb=(196, 56, 72),
    first_finish="matte",
    finishes=_FINISHES,
    is_read=True,
    remark="a veil, so all of the skin's texture and shine stays",
    dials=(
        Dial("height", 0.35, "Height", "Where it begins: 0 on the apple of the cheek, 1 on the "
             "cheekbone."),
        Dial("reach", 0.45, "Reach", "How far it reaches towards the temple."),
        Dial("across", 0.0, "Across", "How strongly it crosses the nose."),
        Dial("size", 0.5, "Size", "How wide it is."),
        Dial("softness", 0.8, "Softness", "How far it fades."),
    ),
    order=10,
    region="face",
    coats=_coats,
    spared=0.3,
)  # fmt: skip
