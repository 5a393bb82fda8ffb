"""Tells by how dark the skin below the eye is whether an eyeliner has a lower line.

On real photos, what the net returns for lower lines is little better than chance
(docs/decisions/reference.md).
"""

import numpy as np
from makeup_video.pipeline.reference.neutral_face import LUMINANCE

# Of flat eyes: the rows of lower lines and the smoke around them, the rows of the skin below those,
# and the columns between the corners.
_NEAR, _FURTHER, _COLUMNS = np.s_[20:22], np.s_[24:27], np.s_[14:36]
_SHARE = 0.3  # share of the darkness further below that is taken off, since it is shadow
_FAINTEST = 2.5e-3  # below this luminance, as a share of skin's, there is only noise
_DARK_FROM = 0.66  # from this darkness on there is a line
_REACH = 0.45  # length of the line from the outer corner, as the dial of eyeliner has it


def lower_line(eyes: np.ndarray | None) -> float:
    """The dial `lower` of an eyeliner that is worn; 0 for no lower line.

    eyes: (27, 48, 3) from mean_eye; None when no eye is seen.
    """
    return _REACH if eyes is not None and darkness(eyes) >= _DARK_FROM else 0.0


def darkness(eyes: np.ndarray) -> float:
    """How dark the skin close below the eye is; eyes: (27, 48, 3) from mean_eye.

    0 for skin as light as plain skin, 1 if its roots of light are about a third of that. Part of
    the darkness further below is taken off.
    """
    light = np.log(np.maximum(eyes.astype(np.float64) ** 2 @ LUMINANCE, _FAINTEST)) / 2
    return float(_SHARE * light[_FURTHER, _COLUMNS].mean() - light[_NEAR, _COLUMNS].mean())
