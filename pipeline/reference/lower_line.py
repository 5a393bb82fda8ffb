"""Tells whether an eyeliner has a lower line: by how dark the skin below the eye is.

What the net returns for lower lines is little better than chance on real photos
(docs/decisions/reference.md).
"""

import numpy as np
from makeup_video.pipeline.reference.neutral_face import LUMINANCE

# Of flat eyes: rows where lower lines and their smoke are, rows of the skin below them, and columns
# between the corners.
_NEAR, _FURTHER, _COLUMNS = np.s_[20:22], np.s_[24:27], np.s_[14:36]
_SHARE = 0.3  # of the darkness further below that is taken off: it is shade
_FAINTEST = 2.5e-3  # luminance as a share of skin's, below which there is only noise
_DARK_FROM = 0.66  # from which there is a line
_REACH = 0.45  # of the line from the outer corner, as the dial of eyeliner


def lower_line(eyes: np.ndarray | None) -> float:
    """The dial `lower` of an eyeliner that is worn, 0 for no line.

    eyes: (27, 48, 3) as of mean_eye, None where no eye is seen.
    """
    return _REACH if eyes is not None and darkness(eyes) >= _DARK_FROM else 0.0


def darkness(eyes: np.ndarray) -> float:
    """Of the skin below the eye, (27, 48, 3): 0 as light as plain skin, 1 where its roots of light
    are a third."""
    light = np.log(np.maximum(eyes.astype(np.float64) ** 2 @ LUMINANCE, _FAINTEST)) / 2
    return float(_SHARE * light[_FURTHER, _COLUMNS].mean() - light[_NEAR, _COLUMNS].mean())
