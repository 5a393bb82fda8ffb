"""Augments crops of faces: light, lenses, noise, codecs, and things in front of the face."""

import cv2
import numpy as np

# Drawn once: each picture takes a piece of it, which is much faster than new noise.
_noise = np.random.default_rng(0).normal(size=(1 << 20)).astype(np.float32)


def photograph(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The crop as some camera might have taken it. (H, W, 3) uint8, encoded, in and out."""
    h, w = rgb8.shape[:2]
    u = rng.random(10)
    if rng.random() < 0.15:
        return rgb8
    if u[0] < 0.4:  # a smaller or softer original
        if u[1] < 0.6:
            part = rng.uniform(0.35, 0.9)
            small = cv2.resize(rgb8, (max(int(w * part), 8), max(int(h * part), 8)),
                               interpolation=cv2.INTER_AREA)  # fmt: skip
            rgb8 = cv2.resize(small, (w, h), interpolation=cv2.INTER_LINEAR)
        elif u[1] < 0.8:
            rgb8 = cv2.GaussianBlur(rgb8, (0, 0), rng.uniform(0.4, 1.6))
        else:
            rgb8 = motion_blur(rgb8, rng)
    elif u[0] < 0.55:  # sharpened by the camera
        soft = cv2.GaussianBlur(rgb8, (0, 0), 1.2)
        gain = rng.uniform(0.3, 1.2)
        rgb8 = cv2.addWeighted(rgb8, 1 + gain, soft, -gain, 0)
    picture = cv2.transform(rgb8.astype(np.float32), colour_matrix(rng))
    if u[2] < 0.4:
        picture *= light(rng, w, h)
    if u[3] < 0.5:
        sigma = np.abs(rng.normal()) * 7
        picture += sigma * grain(picture.shape, rng, coarse=u[4] < 0.4)
    rgb8 = cv2.LUT(picture.clip(0, 255).astype(np.uint8), tone_curve(rng))
    if u[5] < 0.2:
        rgb8 = jpeg(rgb8, int(rng.integers(15, 80)))
    return rgb8


def jpeg(rgb8: np.ndarray, quality: int) -> np.ndarray:
    """The picture after compression as JPEG.

    OpenCV takes B'G'R'. Given R'G'B', it would count red as little in luma as blue, and blur red.
    """
    bgr8 = cv2.cvtColor(rgb8, cv2.COLOR_RGB2BGR)
    data = cv2.imencode(".jpg", bgr8, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def grain(shape: tuple[int, ...], rng: np.random.Generator, coarse: bool) -> np.ndarray:
    """Noise of sigma 1, float32. coarse: as in an enlarged picture."""
    size = int(np.prod(shape))
    start = int(rng.integers(len(_noise) - size))
    noise = _noise[start : start + size].reshape(shape)
    return cv2.GaussianBlur(noise, (3, 3), 0) * 2 if coarse else noise


def restyle(rgb8: np.ndarray, mask: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Now and then change the lipstick, beard or mouth opening. mask: (H, W, 4) as in Batch."""
    whole, opening = mask[..., 0], mask[..., 1]
    u = rng.random(3)
    if u[0] < 0.45:
        rgb8 = lipstick(rgb8, np.minimum(whole, 255 - opening), rng)
    if u[1] < 0.2:
        rgb8 = stubble(rgb8, whole, rng)
    if u[2] < 0.25:  # opening darker in shadow, or teeth in brighter light
        gain = 2 ** rng.uniform(-2.5, 0.6) - 1
        changed = rgb8 * (1 + opening[..., None] * np.float32(gain / 255))
        rgb8 = changed.clip(0, 255).astype(np.uint8)
    return rgb8


def stubble(rgb8: np.ndarray, whole: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw short dark or grey hairs around the mouth. whole: (H, W) uint8, the mouth."""
    h, w = whole.shape
    start = int(rng.integers(len(_noise) - h * w))
    hairs = cv2.GaussianBlur(_noise[start : start + h * w].reshape(h, w), (0, 0), 0.5,
                             sigmaY=rng.uniform(0.6, 2.5)) * 3  # fmt: skip
    cells = rng.random((3, 4)).astype(np.float32) * rng.uniform(0.1, 0.9)
    dense = cv2.resize(cells, (w, h), interpolation=cv2.INTER_LINEAR) * (1 - whole / 255)
    weight = (dense * (hairs + 0.8)).clip(0, 1)[..., None]
    hair = np.float32(rng.uniform(10, 90) if rng.random() < 0.8 else rng.uniform(120, 220))
    return (rgb8 + weight * (hair - rgb8)).clip(0, 255).astype(np.uint8)


def harsh(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Add cast shadows, clipped lights, gloss, a tint or loss of colour, and halos."""
    h, w = rgb8.shape[:2]
    u = rng.random(6)
    picture = rgb8.astype(np.float32)
    if u[0] < 0.4:
        picture *= cast_shadow(rng, w, h)[..., None]
    if u[1] < 0.35:  # gloss, sweat, a flash
        shine = np.zeros((h, w), np.float32)
        for _ in range(int(rng.integers(1, 7))):
            middle = rng.normal([w / 2, h / 2], [w / 5, h / 5])
            axes = (rng.uniform(1, 8), rng.uniform(0.6, 3))
            cv2.ellipse(shine, (tuple(middle), axes, rng.uniform(-35, 35)), 1, -1)
        shine = cv2.GaussianBlur(shine, (0, 0), rng.uniform(0.5, 2.5))
        picture += shine[..., None] * np.float32(rng.uniform(40, 180))
    if u[2] < 0.3:  # faded to one tint, as in old prints and stage light
        grey = picture @ np.array([0.299, 0.587, 0.114], np.float32)
        tint = np.exp(rng.normal(0, 0.35, 3))
        tinted = grey[..., None] * (tint / tint.mean()).astype(np.float32)
        picture += (tinted - picture) * np.float32(rng.uniform(0.4, 1))
    if u[3] < 0.3:  # contrast about a random middle, clipped at both ends
        middle = picture.mean() * np.float32(rng.uniform(0.7, 1.3))
        picture = (picture - middle) * np.float32(rng.uniform(1.2, 2.2)) + middle
    if u[4] < 0.2:
        picture *= np.float32(2 ** rng.uniform(0.3, 1.1))
    picture = picture.clip(0, 255).astype(np.uint8)
    if u[5] < 0.25:
        soft = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.7, 2))
        gain = rng.uniform(0.8, 2.5)
        picture = cv2.addWeighted(picture, 1 + gain, soft, -gain, 0)
    return picture


def cast_shadow(rng: np.random.Generator, w: int, h: int) -> np.ndarray:
    """Gain (H, W) of a cast shadow with a straight or a curved edge."""
    shape = np.zeros((h, w), np.float32)
    angle, middle = rng.uniform(0, 2 * np.pi), rng.uniform([0.1 * w, 0.1 * h], [0.9 * w, 0.9 * h])
    away = np.array([np.cos(angle), np.sin(angle)])
    along = np.array([-away[1], away[0]])
    bends = np.linspace(-1.5, 1.5, 7)[:, None] * w * along + rng.normal(0, 5, (7, 1)) * away
    far = [2 * w * (away + along), 2 * w * (away - along)]
    corners = middle + np.vstack([bends, far])
    cv2.fillPoly(shape, [np.rint(corners).astype(np.int32)], 1.0)
    shape = cv2.GaussianBlur(shape, (0, 0), rng.uniform(0.5, 6))
    return 1 - shape * np.float32(rng.uniform(0.2, 0.85))


def lipstick(rgb8: np.ndarray, mask: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Paint lips in any colour, sheer to opaque, matte to glossy. mask: (H, W) uint8, the lips."""
    inside = mask > 127
    if inside.sum() < 20:
        return rgb8
    colour, kind = rng.uniform(0, 255, 3), rng.random()
    if kind < 0.6:  # reds, pinks, browns
        red = rng.uniform(40, 250)
        colour = np.array([red, red * rng.uniform(0.05, 0.7), red * rng.uniform(0.1, 0.75)])
    elif kind < 0.85:  # nude: nearly the colour of the skin beside the lips
        colour = np.median(rgb8[mask < 30], 0) * rng.uniform(0.75, 1.1) * rng.uniform(0.9, 1.1, 3)
    picture = rgb8.astype(np.float32)
    luma = picture @ np.array([0.299, 0.587, 0.114], np.float32)
    shade = (luma / max(luma[inside].mean(), 1)) ** rng.uniform(0.5, 1.6)
    painted = shade[..., None] * colour.astype(np.float32)
    if rng.random() < 0.4:
        painted += (luma > np.percentile(luma[inside], 88))[..., None] * rng.uniform(20, 90)
    weight = mask[..., None] * (rng.uniform(0.3, 1.0) / 255)
    return (picture + weight * (painted - picture)).clip(0, 255).astype(np.uint8)


def colour_matrix(rng: np.random.Generator) -> np.ndarray:
    """Exposure, white balance and saturation as one (3, 3)."""
    gain = 2 ** rng.normal(0, 0.3) * np.exp(rng.normal(0, 0.08, 3))
    saturation = 0.0 if rng.random() < 0.1 else rng.uniform(0.4, 1.5)
    grey = np.array([[0.299, 0.587, 0.114]]).repeat(3, 0)
    matrix = saturation * np.eye(3) + (1 - saturation) * grey
    return (matrix * gain[:, None]).astype(np.float32)


def tone_curve(rng: np.random.Generator) -> np.ndarray:
    x = np.linspace(0, 1, 256) ** np.exp(rng.normal(0, 0.25))
    contrast = rng.uniform(-0.35, 0.6)
    x = x + contrast * (x * x * (3 - 2 * x) - x)
    return (x * 255).clip(0, 255).astype(np.uint8)


def light(rng: np.random.Generator, w: int, h: int) -> np.ndarray:
    """A smooth gain (H, W, 3): hard, soft or coloured light from a side, and shadows."""
    if rng.random() < 0.6:
        angle, strength = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 1.2)
        edge = rng.uniform(0.5, 4)  # hardness of the terminator
        x, y = np.meshgrid(np.linspace(-1, 1, 12), np.linspace(-1, 1, 12))
        side = np.tanh(edge * (np.cos(angle) * x + np.sin(angle) * y + rng.normal() * 0.4))
        gain = np.exp2(side * strength)[..., None] * np.ones(3)
    else:
        cells = int(rng.integers(2, 6))
        gain = np.exp2(rng.normal(0, 0.5, (cells, cells, 1)) * np.ones(3))
    if rng.random() < 0.4:
        gain = gain ** (1 + rng.normal(0, 0.2, 3))
    return cv2.resize(gain.astype(np.float32), (w, h), interpolation=cv2.INTER_LINEAR)


def motion_blur(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    taps = np.zeros((7, 7), np.float32)
    angle, reach = rng.uniform(0, np.pi), rng.uniform(1, 3)
    end = np.array([np.cos(angle), np.sin(angle)]) * reach
    cv2.line(taps, tuple(np.rint(3 - end).astype(int).tolist()),
             tuple(np.rint(3 + end).astype(int).tolist()), 1.0, 1)  # fmt: skip
    return cv2.filter2D(rgb8, -1, taps / taps.sum())


class Occluder:
    """Draws hands, cups, microphones and hair: blobs, bars and strands, flat or textured.

    mouth: also draws fingers and microphones right over the lips.
    """

    def __init__(self, pictures: list[list[np.ndarray]], mouth: bool = False) -> None:
        self.pictures, self.mouth = pictures, mouth
        self.chance = 0.25

    def __call__(
        self, crop: np.ndarray, at: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray | None:
        """Draw over `crop` in place, with the probability `chance`.

        Returns which of the points `at` (K, 2) px are hidden, or None when nothing is drawn.
        `shape` keeps the share of each px that was covered, (H, W) float32.
        """
        self.shape = None
        if rng.random() >= self.chance:
            return None
        h, w = crop.shape[:2]
        if self.mouth and rng.random() < 0.5:
            shape, cover = (fingers if rng.random() < 0.6 else microphone)(crop, rng)
        else:
            shape, cover = self._shape(w, h, rng), self._texture(w, h, crop, rng)
        soft = cv2.GaussianBlur(shape, (0, 0), rng.uniform(0.4, 1.2)).astype(np.float32) / 255
        mixed = crop + (cover - crop.astype(np.float32)) * soft[..., None]
        crop[:] = mixed.clip(0, 255)
        self.shape = soft
        x, y = np.rint(at).astype(int).T
        return soft[y.clip(0, h - 1), x.clip(0, w - 1)] > 0.5

    def _shape(self, w: int, h: int, rng: np.random.Generator) -> np.ndarray:
        shape = np.zeros((h, w), np.uint8)
        kind = rng.random()
        if kind < 0.35:  # a blob, often cut by a border
            angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
            radius = rng.uniform(0.5, 1.2, 9) * w * rng.uniform(0.12, 0.4)
            middle = rng.uniform([0, 0], [w, h])
            edge = middle + radius[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
            cv2.fillPoly(shape, [np.rint(edge).astype(np.int32)], 255)
        elif kind < 0.75:  # thick bars, such as fingers and microphones
            for _ in range(int(rng.integers(1, 5))):
                start = rng.uniform([0, 0], [w, h])
                end = start + rng.normal(size=2) * w
                thick = max(2, int(rng.uniform(0.04, 0.22) * w))
                line(shape, start, end, thick)
                if rng.random() < 0.3:
                    cv2.circle(shape, tuple(np.rint(start).astype(int).tolist()), thick, 255, -1)
        else:  # strands
            for _ in range(int(rng.integers(1, 12))):
                start = rng.uniform([0, 0], [w, h])
                line(shape, start, start + rng.normal(size=2) * w * 0.5, 1)
        return shape

    def _texture(self, w: int, h: int, crop: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        kind = rng.random()
        if kind < 0.35:  # a colour, with some light on it
            flat = np.full((h, w, 3), rng.uniform(0, 255, 3), np.float32)
            return flat * light(rng, w, h)
        if kind < 0.6:  # a colour of the crop, such as the same skin on a hand
            skin = crop.reshape(-1, 3)[rng.integers(h * w)].astype(np.float32)
            return np.full((h, w, 3), skin * rng.uniform(0.6, 1.3), np.float32) * light(rng, w, h)
        other = self.pictures[int(rng.integers(len(self.pictures)))][-1]
        y, x = (int(rng.integers(0, max(size - 40, 1))) for size in other.shape[:2])
        return cv2.resize(other[y : y + 64, x : x + 64], (w, h)).astype(np.float32)


def fingers(crop: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """One to four round bars side by side in the colour of the face's skin.

    Returns their shape (H, W) uint8 and colours (H, W, 3) float32.
    """
    h, w = crop.shape[:2]
    skin = crop[int(rng.integers(h * 3 // 4, h)), int(rng.integers(w // 4, w * 3 // 4))]
    skin = skin.astype(np.float32) * np.float32(rng.uniform(0.7, 1.25))
    shape, cover = np.zeros((h, w), np.uint8), np.zeros((h, w, 3), np.float32)
    angle, radius = rng.uniform(0, 2 * np.pi), rng.uniform(4, 11)
    along = np.array([np.cos(angle), np.sin(angle)])
    tip = rng.normal([w / 2, h / 2], [w / 5, h / 5])
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    for finger in range(int(rng.integers(1, 5))):
        start = tip + finger * 1.9 * radius * np.array([-along[1], along[0]]) + rng.normal(0, 3, 2)
        dx, dy = x - start[0], y - start[1]
        ahead = np.maximum(dx * along[0] + dy * along[1], 0)
        off = np.hypot(dx - ahead * along[0], dy - ahead * along[1]) / radius
        inside = off < 1
        shape[inside] = 255
        round_off = np.sqrt(np.maximum(1 - off**2, 0)) * 0.45 + 0.6
        cover[inside] = round_off[inside, None] * skin
    return shape, cover * light(rng, w, h)


def microphone(crop: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A ball of foam or wire mesh on a stick from below. Returns the same as `fingers`."""
    h, w = crop.shape[:2]
    shape = np.zeros((h, w), np.uint8)
    middle, radius = rng.normal([w / 2, h * 0.75], [w / 5, h / 6]), rng.uniform(8, 22)
    end = middle + np.array([rng.normal() * w * 0.5, h])
    line(shape, middle, end, max(3, int(radius * rng.uniform(0.6, 1.4))))
    cv2.circle(shape, tuple(np.rint(middle).astype(int).tolist()), int(radius), 255, -1)
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    pitch = rng.uniform(1.2, 3)
    mesh = (np.sin(x * pitch) * np.sin(y * pitch))[..., None] * np.float32(rng.uniform(0, 35))
    shine = np.exp(-np.hypot(x - middle[0] + radius / 3, y - middle[1] + radius / 3) / radius)
    colour = np.float32(rng.uniform(0, 70) if rng.random() < 0.75 else rng.uniform(70, 200))
    cover = colour * (0.6 + 1.2 * shine[..., None]) + mesh + np.zeros(3, np.float32)
    return shape, cover * light(rng, w, h)


def line(shape: np.ndarray, start: np.ndarray, end: np.ndarray, thick: int) -> None:
    a, b = (tuple(np.rint(p).astype(int).tolist()) for p in (start, end))
    cv2.line(shape, a, b, 255, thick, cv2.LINE_AA)
