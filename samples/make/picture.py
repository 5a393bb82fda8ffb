"""Enlarges the photograph and separates it into layers: backdrop, body and head.

This folder uses two coordinate systems. "Picture" pixels are those of the 512 x 512 photograph;
"canvas" pixels are those of the enlarged crop that all layers share. In both, (0, 0) is the centre
of the top left pixel, x points right and y down.
Colours are float32 RGB, gamma-coded as in the photograph (sRGB), 0..1.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import skimage.data
from numpy.typing import NDArray
from scipy import ndimage

Image = NDArray[np.float32]

SCALE = 3.2  # canvas pixels per picture pixel
LEFT, TOP, RIGHT, BOTTOM = 6, -16, 446, 244  # the crop, in picture pixels
WIDTH, HEIGHT = round((RIGHT - LEFT) * SCALE), round((BOTTOM - TOP) * SCALE)

# Outlines drawn by hand on the photograph, in picture pixels.
PERSON_SURE = [
    [(166, 100), (160, 78), (172, 58), (186, 38), (215, 22), (245, 22), (272, 36), (290, 62),
     (294, 90), (286, 112), (272, 128), (262, 150), (250, 172), (262, 182), (284, 202), (300, 232),
     (306, 256), (330, 262), (346, 290), (30, 290), (60, 262), (100, 222), (118, 208), (120, 184),
     (136, 162), (160, 154), (190, 156), (190, 140), (184, 122), (176, 112)],
    [(112, 186), (116, 183), (124, 184), (124, 198), (113, 193)],
]  # fmt: skip
PERSON_NEVER = [
    [(0, 0), (512, 0), (512, 300), (372, 300), (352, 252), (312, 228), (310, 206), (290, 180),
     (262, 168), (276, 142), (296, 122), (310, 90), (306, 50), (280, 20), (236, 6), (196, 10),
     (168, 34), (150, 60), (146, 92), (154, 112), (166, 130), (180, 142), (158, 144), (134, 150),
     (110, 178), (104, 200), (84, 206), (40, 238), (0, 262)],
]  # fmt: skip
NECK = [(184, 120), (186, 150), (187, 178), (178, 200), (196, 216), (250, 216), (266, 200),
        (255, 182), (258, 150), (262, 120)]  # fmt: skip
HEAD = [(100, -20), (350, -20), (330, 120), (268, 150), (257, 160), (255, 172), (253, 184),
        (262, 200), (250, 216), (196, 216), (178, 200), (187.2, 177), (186.8, 152), (184.5, 147),
        (178, 140), (120, 120)]  # fmt: skip
COLLAR_BACK = ((181.5, 147.9), (262.0, 176.9))  # the hidden arc of the ring, behind the neck


@dataclass(frozen=True)
class Layers:
    """The canvas layers, each float32 (HEIGHT, WIDTH, 3 or 4); RGBA is premultiplied."""

    backdrop: Image
    body: Image
    head: Image


def to_canvas(points: NDArray[np.floating]) -> NDArray[np.float32]:
    """Convert picture pixels (..., 2 or 3) to canvas pixels; z is only scaled."""
    out = np.asarray(points, np.float64) * SCALE
    out[..., :2] += (0.5 - np.array([LEFT, TOP])) * SCALE - 0.5
    return out.astype(np.float32)


def smoothstep(low: float, high: float, x: Image) -> Image:
    """Return 0 below low, 1 above high, smooth between; low may exceed high."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return (t * t * (3 - 2 * t)).astype(np.float32)


def blur(image: Image, sigma: float) -> Image:
    """Blur with a Gaussian; sigma in pixels."""
    return cv2.GaussianBlur(image, (0, 0), sigma, borderType=cv2.BORDER_REFLECT_101)


def polygon(points: list[tuple[float, float]], sigma: float = 0.0) -> Image:
    """Fill a polygon of picture points as a canvas mask, float32 (HEIGHT, WIDTH), 0..1."""
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    corners = np.round(to_canvas(np.array(points)) * 16).astype(np.int32)
    cv2.fillPoly(mask, [corners], 255, cv2.LINE_AA, 4)
    return blur(mask.astype(np.float32) / 255, sigma) if sigma else mask.astype(np.float32) / 255


def spread(image: Image, known: NDArray[np.bool_], sigma: float) -> Image:
    """Fill unknown pixels with the nearest known colours, smoothed by sigma pixels."""
    index = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    filled = image[tuple(index)]
    return np.where(known[..., None], image, blur(filled, sigma)).astype(np.float32)


def enlarge(picture: NDArray[np.uint8]) -> Image:
    """Enlarge the crop SCALE times and sharpen it without halos, (HEIGHT, WIDTH, 3)."""
    ycc = cv2.cvtColor(cv2.bilateralFilter(picture, 5, 10, 1.2), cv2.COLOR_RGB2YCrCb)
    ycc[..., 1:] = cv2.bilateralFilter(np.ascontiguousarray(ycc), 9, 16, 2.5)[..., 1:]
    clean = cv2.cvtColor(ycc, cv2.COLOR_YCrCb2RGB)
    pad = cv2.copyMakeBorder(clean, -TOP, 0, 0, 0, cv2.BORDER_REPLICATE)[: BOTTOM - TOP, LEFT:RIGHT]
    size = (WIDTH, HEIGHT)
    big = cv2.resize(pad.astype(np.float32) / 255, size, interpolation=cv2.INTER_LANCZOS4)
    sharp = big + 0.9 * (big - blur(big, 1.7)) + 0.4 * (big - blur(big, 3.6))
    # Overshoot makes enlargements look artificial: keep within the neighbours' range.
    box = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))
    low, high = cv2.erode(big, box), cv2.dilate(big, box)
    return np.clip(sharp, np.maximum(low - 0.02, 0), np.minimum(high + 0.02, 1))


def add_detail(image: Image, rng: np.random.Generator) -> Image:
    """Add fine texture that the photograph is too small to hold.

    Busy areas get strands along the direction of the hair; smooth areas get pores.
    """
    grey = image @ np.float32([0.2126, 0.7152, 0.0722])
    gx, gy = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    jxx, jyy, jxy = blur(gx * gx, 5), blur(gy * gy, 5), blur(gx * gy, 5)
    angle = 0.5 * np.arctan2(2 * jxy, jxx - jyy) + np.pi / 2  # along the strands
    noise = rng.standard_normal(grey.shape, np.float32)
    strands = blur(_along(noise, np.cos(angle), np.sin(angle), 14), 0.6)
    strands /= strands.std()
    pores = blur(rng.standard_normal(grey.shape, np.float32), 0.8)
    pores -= blur(pores, 2.5)
    pores /= pores.std()
    # Where the direction is uncertain, strands would zigzag.
    clear = np.sqrt((jxx - jyy) ** 2 + 4 * jxy**2) / np.maximum(jxx + jyy, 1e-6)
    busy = np.sqrt(blur((grey - blur(grey, 9)) ** 2, 9))
    face = polygon([(184, 84), (266, 88), (264, 130), (258, 152), (256, 190), (186, 190),
                    (185, 150), (182, 128)], 6)  # fmt: skip
    amount = 0.34 * clear * np.minimum(busy, 0.07) * (1 - face) * polygon(HEAD, 4)
    detail = strands * amount + pores * 0.008 * np.sqrt(np.clip(grey, 0, 1))
    return np.clip(image + detail[..., None], 0, 1).astype(np.float32)


def _along(noise: Image, ux: Image, uy: Image, steps: int) -> Image:
    """Average noise `steps` pixels both ways along (ux, uy): line integral convolution."""
    ys, xs = np.mgrid[: noise.shape[0], : noise.shape[1]].astype(np.float32)
    total = noise.copy()
    for sign in (-1.0, 1.0):
        x, y, px, py = xs.copy(), ys.copy(), sign * ux, sign * uy
        for _ in range(steps):
            x, y = x + px, y + py
            vx = cv2.remap(ux.astype(np.float32), x, y, cv2.INTER_NEAREST)
            vy = cv2.remap(uy.astype(np.float32), x, y, cv2.INTER_NEAREST)
            turn = np.sign(vx * px + vy * py)  # the direction has no sign
            px, py = vx * turn, vy * turn
            total += cv2.remap(noise, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return total


def person_matte(picture: NDArray[np.uint8], big: Image) -> tuple[Image, Image]:
    """Return the person's alpha (HEIGHT, WIDTH), and the colours spread beyond the edge."""
    trimap = np.full(picture.shape[:2], cv2.GC_PR_FGD, np.uint8)
    cv2.fillPoly(trimap, [np.array(p, np.int32) for p in PERSON_NEVER], cv2.GC_BGD)
    cv2.fillPoly(trimap, [np.array(p, np.int32) for p in PERSON_SURE], cv2.GC_FGD)
    cv2.setRNGSeed(1)
    model = np.zeros((2, 1, 65))
    cv2.grabCut(picture, trimap, None, model[0], model[1], 6, cv2.GC_INIT_WITH_MASK)
    inside = np.isin(trimap, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.float32)
    pad = cv2.copyMakeBorder(inside, -TOP, 0, 0, 0, cv2.BORDER_CONSTANT)
    hard = cv2.resize(
        pad[: BOTTOM - TOP, LEFT:RIGHT], (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC
    )
    hard = smoothstep(0.3, 0.7, blur(hard, 4.0))  # rounds the steps of the small mask
    sure = blur(hard, 3) > 0.9
    never = blur(hard, 3) < 0.06
    front, back = spread(big, sure, 4), spread(big, never, 6)
    # Between the two, alpha is the position on the line from back to front colour.
    axis = front - back
    length = (axis**2).sum(-1)
    share = ((big - back) * axis).sum(-1) / np.maximum(length, 1e-4)
    trust = smoothstep(0.01, 0.06, length) * polygon(HEAD, 3)
    alpha = trust * smoothstep(0.08, 0.92, share) + (1 - trust) * smoothstep(0.3, 0.7, hard)
    alpha = np.where(sure, 1, np.where(never, 0, alpha)).astype(np.float32)
    alpha = blur(alpha, 1.3)
    return alpha, np.where(alpha[..., None] > 0.9, big, front).astype(np.float32)


def backdrop(big: Image, alpha: Image, rng: np.random.Generator) -> Image:
    """Return the studio backdrop without the person, out of focus, (HEIGHT, WIDTH, 3)."""
    hole = cv2.dilate(alpha, np.ones((21, 21))) > 0.01
    small = cv2.resize(big, None, fx=0.125, fy=0.125, interpolation=cv2.INTER_AREA)
    mask = cv2.resize(hole.astype(np.uint8) * 255, small.shape[1::-1]) > 0
    mask[:, : mask.shape[1] // 4] = True  # the flag must not grow into the gap beside it
    coarse = np.round(small * 255).astype(np.uint8)
    filled = cv2.inpaint(coarse, mask.astype(np.uint8), 9, cv2.INPAINT_TELEA)
    filled = cv2.resize(blur(filled.astype(np.float32) / 255, 2.5), (WIDTH, HEIGHT))
    mottle = cv2.resize(rng.standard_normal((18, 30)).astype(np.float32), (WIDTH, HEIGHT),
                        interpolation=cv2.INTER_CUBIC)  # fmt: skip
    filled = filled + 0.012 * mottle[..., None]
    soft = blur(hole.astype(np.float32), 6)[..., None]
    return blur(filled * soft + big * (1 - soft), 3.5)


def behind_neck(colours: Image) -> tuple[Image, Image]:
    """Paint the hidden back arc of the collar; return canvas colours and their mask.

    Every hidden column blends the two visible columns beside the neck, moved along the arc.
    """
    (x0, y0), (x1, y1) = to_canvas(np.array(COLLAR_BACK))
    ys, xs = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    t = np.clip((xs - x0) / (x1 - x0), 0, 1)
    down = ys - (y0 + (y1 - y0) * t - 14 * np.sin(np.pi * t))
    one = cv2.remap(colours, np.full_like(xs, x0), down + y0, cv2.INTER_LINEAR)
    two = cv2.remap(colours, np.full_like(xs, x1), down + y1, cv2.INTER_LINEAR)
    return one * (1 - t[..., None]) + two * t[..., None], smoothstep(-1, 1, down)


def build_layers(seed: int = 1) -> Layers:
    """Separate the photograph into layers."""
    rng = np.random.default_rng(seed)
    picture = skimage.data.astronaut()
    big = enlarge(picture)
    alpha, colours = person_matte(picture, big)
    back = backdrop(big, alpha, rng)
    colours = add_detail(colours, rng)
    head_share = polygon(HEAD, 1.5) * alpha
    low = smoothstep(*to_canvas(np.array([[0, 214.0], [0, 196.0]]))[:, 1],
                     np.mgrid[:HEIGHT, :WIDTH][0].astype(np.float32))  # fmt: skip
    head_alpha = head_share * low
    hidden = cv2.dilate(polygon(HEAD), np.ones((25, 25))) * low
    arc, arc_alpha = behind_neck(colours)
    body_alpha = alpha * (1 - hidden) + arc_alpha * hidden
    body_colours = colours * (1 - hidden[..., None]) + arc * hidden[..., None]
    return Layers(
        back,
        np.dstack([body_colours * body_alpha[..., None], body_alpha]).astype(np.float32),
        np.dstack([colours * head_alpha[..., None], head_alpha]).astype(np.float32),
    )
