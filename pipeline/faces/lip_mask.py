"""The lip mask: where lips are in a picture, from a face's lip patch."""

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face, check_face_type, is_sound
from makeup_video.pipeline.frames.views import check_rgb8

_INVISIBLE = 1 / 512  # half a code value of 8 bits


def lip_mask(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """Where the lip net sees lips: 1 on the lips, 0 beyond their soft edge.

    Painting also follows the contours of the landmarks, and has a soft edge of its own. So a pixel
    beside the border may be painted where this mask is 0, or the other way round.

    rgb8: (H, W, 3) uint8, encoded R'G'B', the picture that `face` was found in. Returns (H, W)
    float32 in [0, 1]. The mouth opening is 0, so teeth keep their colour, and so is a hand in front
    of the lips. The whole mask is 0 when the mouth is hidden (`mouth_visible`), when the lips lie
    outside the picture, and for a face whose numbers are not finite. Raises ValueError for another
    shape or dtype, TypeError for anything but a Face.
    """
    check_rgb8(rgb8)
    check_face_type(face)
    size = np.array(rgb8.shape[1::-1])
    mask = np.zeros(rgb8.shape[:2], np.float32)
    if not is_sound(face):
        return mask
    h, w = face.lips.logits.shape
    corners = face.lips.to_px @ np.array([[0, w, 0, w], [0, 0, h, h], [1, 1, 1, 1]])
    x0, y0 = np.clip(np.floor(corners.min(1)) - 2, 0, size).astype(int)
    x1, y1 = np.clip(np.ceil(corners.max(1)) + 2, 0, size).astype(int)
    if x1 > x0 and y1 > y0:
        mask[y0:y1, x0:x1] = lip_mask_part(face, (x0, y0), (int(x1 - x0), int(y1 - y0)))
    return mask


def lip_mask_part(face: Face, origin_xy: tuple[int, int], size_wh: tuple[int, int]) -> np.ndarray:
    """The lip mask in a part of the picture that begins at origin_xy: (H, W) float32 in [0, 1]."""
    to_part = face.lips.to_px.copy()
    to_part[:, 2] -= origin_xy
    # Logits are interpolated, not weights: their zero crossing is the border at any scale.
    logits = cv2.warpAffine(
        face.lips.logits.clip(-20, 20),
        to_part,
        size_wh,
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REPLICATE,
    )
    # The patch's outside is warped by itself: a cubic interpolation would overshoot at its border.
    beyond = cv2.warpAffine(np.zeros_like(face.lips.logits), to_part, size_wh, borderValue=-30)
    logits = cv2.add(logits, beyond)
    weight: np.ndarray = 1 / (1 + np.exp(-logits.clip(-30, 30)))
    weight *= face.mouth_weight
    weight[weight < _INVISIBLE] = 0
    return weight.astype(np.float32, copy=False)
