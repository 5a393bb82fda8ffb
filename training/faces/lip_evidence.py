"""Features that tell whether a pixel is lip: the teacher's contours, the face's colours, a net.

The teacher is MediaPipe, whose points label the training faces.
"""

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import LIPS, LIPS_INNER, LIPS_OUTER
from makeup_video.training.faces.contour import fill
from makeup_video.training.faces.crops import MASK_SPAN, CropSpec
from makeup_video.training.faces.infer import Net, take

MASK_SPEC = CropSpec((192, 144), MASK_SPAN, LIPS, LIPS)
IOD = MASK_SPEC.size_wh[0] / MASK_SPEC.span  # px of the mask crop
TRIALS = 8  # crops of each mouth for a net
UNSURE = 6.0  # logits are clipped to this: larger ones mean the same


def to_mask_px(points: np.ndarray, to_image: np.ndarray) -> np.ndarray:
    """Image px (K, >=2) -> px of the mask crop (K, 2)."""
    w, h = MASK_SPEC.size_wh
    at = (points[:, :2] - to_image[:, 2]) @ np.linalg.inv(to_image[:, :2]).T
    return at * IOD + [(w - 1) / 2, (h - 1) / 2]


def signed_distance(contour_px: np.ndarray) -> np.ndarray:
    """Signed distance (H, W) in px, positive inside a closed contour (K, 2)."""
    inside = np.zeros(MASK_SPEC.size_wh[::-1], np.uint8)
    fill(inside, contour_px)
    inwards = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
    return inwards - cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)


def separate(features: np.ndarray, ours: np.ndarray, theirs: np.ndarray) -> np.ndarray | None:
    """Linear discriminant: features (H, W, F), two sample masks -> log-odds (H, W) of `ours`."""
    a, b = features[ours], features[theirs]
    if min(len(a), len(b)) < 30:
        return None
    middle_a, middle_b = np.median(a, 0), np.median(b, 0)
    spread = (np.cov(a.T) + np.cov(b.T)) / 2 + np.diag([9.0, 1.5, 1.5])
    direction = np.linalg.solve(spread, middle_a - middle_b)
    return (features - (middle_a + middle_b) / 2) @ direction


def line_between(points_px: np.ndarray) -> np.ndarray:
    """(11, 2) points from corner to corner, left to right, midway through the inner contour."""
    lower = points_px[LIPS_INNER[:11]]
    upper = points_px[np.r_[LIPS_INNER[:1], LIPS_INNER[:9:-1]]]
    middle = (lower + upper) / 2
    return middle[np.argsort(middle[:, 0])]


def average_of(
    run: Net, rgb8: np.ndarray, to_image: np.ndarray, spec: CropSpec, seed: int
) -> np.ndarray:
    """A net's mean log-odds of lipstick (144, 192) over crops of one mouth.

    The crops are mirrored, shifted, turned, scaled, and in other tones. spec: of the net.
    """
    rng = np.random.default_rng(seed)
    crops, places = [], []
    for trial in range(TRIALS):
        turn, scale, *shift = rng.normal(size=4) * [*spec.jitter, spec.jitter[2]]
        c, s = np.cos(turn) * np.exp(scale), np.sin(turn) * np.exp(scale)
        placed = np.array([[c, -s, shift[0]], [s, c, shift[1]], [0, 0, 1]])
        crop = take(rgb8, to_image @ placed, spec, flip=trial % 2 == 1)
        gain = np.exp(rng.normal(0, 0.15) + rng.normal(0, 0.04, 3))
        tone = 255 * (np.arange(256)[:, None] / 255) ** np.exp(rng.normal(0, 0.15)) * gain
        crops.append(cv2.LUT(crop, tone.clip(0, 255).astype(np.uint8)[None]))
        places.append(placed[:2])
    logits = run(np.stack(crops))[-1].clip(-UNSURE, UNSURE)
    size, goal = np.array(spec.size_wh), (np.array(MASK_SPEC.size_wh) - 1) / 2
    total = np.zeros(MASK_SPEC.size_wh[::-1], np.float32)
    for trial, (placed, logit) in enumerate(zip(places, logits, strict=True)):
        linear = placed[:, :2] * (spec.span / size[0] * IOD)
        offset = placed[:, 2] * IOD + goal - linear @ ((size - 1) / 2)
        logit = logit[:, ::-1] if trial % 2 else logit
        total += cv2.warpAffine(np.ascontiguousarray(logit), np.column_stack([linear, offset]),
                                MASK_SPEC.size_wh, borderValue=-UNSURE)  # fmt: skip
    return total / TRIALS


def enclosed(log_odds: np.ndarray) -> np.ndarray:
    """Log-odds that a pixel lies between an upper and a lower lip in its column."""
    above = np.maximum.accumulate(log_odds, 0)
    below = np.maximum.accumulate(log_odds[::-1], 0)[::-1]
    return np.minimum(above, below)


def colours(lab: np.ndarray, outer: np.ndarray, inner: np.ndarray,
            middle: np.ndarray) -> list[np.ndarray]:  # fmt: skip
    """Discriminants of the face's own colours, (H, W) each; zeros where none can be fitted."""
    thickness = np.minimum(outer, -inner).max()
    lip = (outer > 0.35 * thickness) & (inner < -0.25 * thickness)
    skin = (outer < -0.035 * IOD) & (outer > -0.13 * IOD)
    y = np.arange(lab.shape[0])[:, None]
    lower_share = 1 / (1 + np.exp(-(y - middle) / (0.03 * IOD)))
    nothing = np.zeros(lab.shape[:2])
    against_skin = nothing.copy()
    for share, half in ((lower_share, y > middle), (1 - lower_share, y <= middle)):
        found = separate(lab, lip & half, skin & half)
        against_skin += 0 if found is None else share * found.clip(-6, 6)
    opening = inner > 0.012 * IOD
    found = separate(lab, lip, opening) if opening.sum() > 60 else None
    against_opening = nothing if found is None else found.clip(-6, 6)
    parts = [against_skin, against_opening]
    for place in (lip, skin):  # add the plain differences from lips and from skin
        usual = np.median(lab[place], 0) if place.sum() > 30 else np.median(lab, (0, 1))
        parts += list(np.moveaxis((lab - usual) / [12, 6, 6], -1, 0).clip(-4, 4))
    return parts


def features(rgb8: np.ndarray, points_px: np.ndarray, net: np.ndarray) -> np.ndarray:
    """Features (144, 192, F) float32 of a mask crop (144, 192, 3), each about 1 in size.

    points_px: the teacher's points in px of the crop. net: (144, 192), a net's mean log-odds.
    """
    lab = cv2.cvtColor(rgb8.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
    lab = cv2.GaussianBlur(lab, (0, 0), 1.0)
    outer, inner = signed_distance(points_px[LIPS_OUTER]), signed_distance(points_px[LIPS_INNER])
    # The line midway through the inner contour divides the upper lip from the lower.
    line = line_between(points_px)
    x, y = np.arange(lab.shape[1])[None], np.arange(lab.shape[0])[:, None]
    middle = np.interp(x[0], *line.T)[None]
    columns = np.ones_like(outer)
    height, gap = (outer > 0).sum(0)[None] / IOD, (inner > 0).sum(0)[None] / IOD
    half = np.linalg.norm(line[-1] - line[0]) / 2
    along = np.abs(x - line[:, 0].mean()) / half
    between = enclosed(net)
    soft = [cv2.GaussianBlur(net, (0, 0), sigma) for sigma in (2.0, 5.0)]
    lab_up, lab_down = (np.roll(lab[..., 0], shift, 0) - lab[..., 0] for shift in (3, -3))
    parts = [
        *[(d / (0.03 * IOD)).clip(-4, 4) for d in (outer, inner)],
        *[(d / (0.2 * IOD)).clip(-4, 4) for d in (outer, inner)],
        *colours(lab, outer, inner, middle),
        net / 3, between / 3, soft[0] / 3, soft[1] / 3, enclosed(soft[0]) / 3,
        ((y - middle) / (0.06 * IOD)).clip(-3, 3), along.clip(0, 2) * columns,
        10 * height * columns, 20 * gap * columns, columns * inner.max() / (0.05 * IOD),
        lab[..., 0] / 50 - 1, lab_up / 10, lab_down / 10,
    ]  # fmt: skip
    return np.stack(parts, -1).astype(np.float32)
