"""What a page must know of a look to offer it for change; ranges and meanings are those of `pipeline/look.py`."""

from dataclasses import fields
from typing import Any

from makeup_video.pipeline.look import GraphicsParams

_LABELS = {
    "red": "Red",
    "green": "Green",
    "blue": "Blue",
    "opacity": "Coverage",
    "gloss": "Gloss",
    "gloss_roughness": "Softness of shine",
    "reflection": "Reflection",
    "edge_softness": "Soft edge",
    "texture_keep": "Fine lines",
    "undertone": "Own skin tone",
    "gloss_detail": "Shine of the skin",
    "fresnel": "Bright rims",
    "environment_blur": "Blur of reflection",
    "shimmer": "Sparkles",
    "shimmer_size": "Size of sparkles",
    "shimmer_tint": "Colour of sparkles",
    "light_adaptation": "Takes on the light",
}
_MOST = 4.0  # a slider needs an end where a look has none: lacquer


def parameters() -> list[dict[str, Any]]:
    """All 17, in the order of a look file: name, low, high, step, label, help."""
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
