"""Highlighter: light on the cheekbones, the nose and cupid's bow."""

from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind, Shape
from makeup_video.pipeline.look.kinds.ramps import faded, stroke
from makeup_video.pipeline.look.params import GraphicsParams

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.50, 0.00, 0.95, 0.00, 0.80, 1.00, 0.00, 0.50, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.42, 0.80, 0.60, 0.02, 0.80, 1.00, 0.05, 0.50, 0.40, 0.70, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.26, 0.50, 0.65, 0.02, 0.80, 1.00, 0.08, 0.60, 0.40, 0.70, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.34, 2.00, 0.35, 0.06, 0.80, 1.00, 0.05, 0.50, 0.60, 0.50, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.58, 1.60, 0.50, 0.06, 0.80, 0.90, 0.00, 0.30, 0.60, 0.50, 0.20, 0.05, 1.00, 1.0),
    "shimmer":  (0.42, 1.10, 0.55, 0.04, 0.80, 0.95, 0.05, 0.40, 0.50, 0.60, 0.30, 0.00, 0.40, 1.0),
}  # fmt: skip
# In distances of the outer eye corners, on the picture's right side of the face.
_CHEEKBONE = (0.52, 0.19), (0.73, 0.05)
_NOSE = (0.0, 0.06), (0.0, 0.40)
_BOW = (-0.04, 0.615), (0.04, 0.615)
_BEYOND = 0.5  # how far a stroke fades beyond its half width
_THIN = {"cheekbone": 0.10, "nose": 0.045, "bow": 0.045}  # half widths at size 0.5


def _coats(at: FaceFields, product: GraphicsParams, shape: Shape) -> list[Coat]:
    """A stroke on each place; where strokes meet, the denser one counts."""
    import numpy as np

    beside = np.abs(at.across)
    soft = faded(0.3 + 0.7 * shape["softness"], product)
    density = np.zeros(np.broadcast_shapes(at.across.shape, at.down.shape), np.float32)
    for name, ends in (("cheekbone", _CHEEKBONE), ("nose", _NOSE), ("bow", _BOW)):
        if shape[name] > 0:
            radius = _THIN[name] * (0.5 + shape["size"])
            drawn = stroke(beside, at.down, ends, radius, soft, _BEYOND)
            np.maximum(density, np.float32(shape[name]) * drawn, out=density)
    return [Coat(product, density)]


KIND = Kind(
    name="highlighter",
    part="highlighter",
    title="Highlight",
    product="Highlighter",
    words=("highlight", "illuminator", "strobe", "glow"),
    must_see="cheeks",
    category=r"(?<![a-z])(highlight|illuminat|strobe)",
    first_rgb=(250, 226, 200),
    first_finish="shimmer",
    finishes=_FINISHES,
    remark="a veil of light, so it covers little and shines",
    dials=(
        Dial("cheekbone", 1.0, "Cheekbones", "How much lies on the cheekbones."),
        Dial("nose", 0.5, "Nose", "How much lies on the ridge of the nose."),
        Dial("bow", 0.5, "Cupid's bow", "How much lies above the middle of the upper lip."),
        Dial("size", 0.5, "Size", "How wide the strokes are."),
        Dial("softness", 0.6, "Softness", "How far they fade."),
    ),
    order=15,
    region="face",
    coats=_coats,
    spared=0.3,
)
