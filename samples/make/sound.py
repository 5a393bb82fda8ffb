"""Synthesises the sound of the clip: a soft sung voice that follows the mouth."""

from __future__ import annotations

import numpy as np
from motion import FPS, FRAMES, mouth
from numpy.typing import NDArray

RATE = 48000


def voice(seed: int = 3) -> NDArray[np.float32]:
    """Return stereo sound for the whole clip, (2, samples) float32, -1..1, at RATE."""
    rng = np.random.default_rng(seed)
    count = RATE * FRAMES // FPS
    t = np.arange(count) / RATE
    # 200 Hz is enough for the mouth, which moves slowly.
    coarse = np.arange(0, t[-1] + 0.01, 0.005)
    _, jaw, narrow = (np.interp(t, coarse, v) for v in np.array([mouth(u) for u in coarse]).T)
    loud = np.clip(jaw * 1.6 - 0.12, 0, 1)
    pitch = 196 * 2 ** ((2 * np.sin(2 * np.pi * t / 2.7) + 3 * jaw - 0.25 * (t % 3.3)) / 12)
    pitch *= 1 + 0.006 * np.sin(2 * np.pi * 5.2 * t)  # vibrato
    phase = 2 * np.pi * np.cumsum(pitch) / RATE
    first, second = 320 + 480 * jaw, 1750 - 900 * np.clip(narrow, 0, 1) - 350 * jaw
    tone = np.zeros(count)
    for k in range(1, 25):
        f = k * pitch
        level = sum(g / (1 + ((f - c) / w) ** 2) for c, w, g in
                    ((first, 90, 1.0), (second, 130, 0.45), (2850.0, 200, 0.18)))  # fmt: skip
        tone += level * k**-0.4 * np.sin(k * phase + 0.7 * k * k)
    breath = 0.02 * rng.standard_normal(count)
    dry = (tone + breath) * loud
    dry *= 0.11 / np.abs(dry).max() * 2
    return np.stack([_room(dry, rng), _room(dry, rng)]).astype(np.float32)


def _room(dry: NDArray, rng: np.random.Generator) -> NDArray:
    """Add the echo of a small room: decaying noise, different for each ear."""
    length = RATE // 4
    tail = rng.standard_normal(length) * np.exp(-np.arange(length) / (0.055 * RATE))
    tail *= 0.35 / np.sqrt((tail**2).sum())
    size = 1 << int(len(dry) + length).bit_length()
    wet = np.fft.irfft(np.fft.rfft(dry, size) * np.fft.rfft(tail, size), size)[: len(dry)]
    return dry + wet
