"""The timeline: pose, mouth, eyes and light of the person at every instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from head import Pose

FPS = 30
FRAMES = 300

# (centre s, width s, jaw 0..1, narrow -1..1) of every syllable; jaw 1 is wide open.
SYLLABLES = [
    (1.00, 0.26, 0.42, 0.0), (1.24, 0.24, 0.20, 0.7), (1.52, 0.30, 0.55, -0.2),
    (1.80, 0.22, 0.25, 0.2), (2.06, 0.28, 0.46, 0.5), (2.34, 0.26, 0.30, -0.3),
    (2.66, 0.34, 0.62, 0.1), (4.30, 0.28, 0.38, -0.2), (4.58, 0.26, 0.22, 0.8),
    (4.88, 0.30, 0.52, 0.2), (5.20, 0.26, 0.34, -0.3), (6.45, 1.05, 1.00, 0.1),
    (7.50, 0.26, 0.34, 0.6), (7.76, 0.28, 0.48, -0.2), (8.04, 0.24, 0.24, 0.4),
    (8.34, 0.32, 0.56, 0.0), (8.66, 0.26, 0.26, 0.3),
]  # fmt: skip
PHRASES = [(0.85, 2.85), (4.12, 5.38), (5.85, 7.05), (7.34, 8.84)]
SMILES = [(3.05, 3.95)]  # teeth shown, mouth at rest
BLINKS = [0.72, 2.42, 3.98, 5.62, 7.18, 8.95]
TURNS = [(0, 0), (0.6, 0), (2.0, -17), (2.9, -12), (4.4, 18), (5.3, 13), (6.4, -3), (7.4, -14),
         (8.4, 9), (9.4, 0), (10, 0)]  # fmt: skip
NODS = [(0, 0), (0.6, 0), (1.3, 5), (2.2, -3), (3.3, -7), (4.4, 3), (5.4, 7), (6.4, -5), (7.5, 5),
        (8.4, -2), (9.4, 0), (10, 0)]  # fmt: skip
TILTS = [(0, 0), (0.7, 0), (1.9, 4), (3.4, -3), (4.6, -5), (6.2, 2), (7.5, 4.5), (8.6, -2),
         (9.4, 0), (10, 0)]  # fmt: skip
GLANCES = [(0, 0), (3.98, 0), (4.06, 7), (4.9, 6), (4.98, 0), (7.2, 0), (7.26, -6), (8.0, -5),
           (8.06, 0), (10, 0)]  # fmt: skip
BROWS = [(0, 0), (1.3, 0.2), (1.6, 0.9), (2.2, 0.1), (5.6, 0.1), (6.2, 1), (7.0, 0.2), (10, 0)]


@dataclass(frozen=True)
class State:
    """One instant.

    close: 1 for lips together, 0 for the photograph's smile.  jaw: 1 for wide open.  narrow: 1 for
    rounded lips.  lids: 1 for closed eyes.  gaze: degrees to the right of the picture.  gain:
    multiplies the code values.
    """

    pose: Pose
    close: float
    jaw: float
    narrow: float
    lids: float
    gaze: float
    brows: float
    gain: float
    camera: tuple[float, float, float]  # shift x, y in pixels, zoom


def _track(keys: list[tuple[float, float]], t: float) -> float:
    """Interpolate (seconds, value) keys by a smooth curve that rests at every key."""
    times, values = np.array(keys, float).T
    i = int(np.clip(np.searchsorted(times, t, "right") - 1, 0, len(times) - 2))
    u = np.clip((t - times[i]) / (times[i + 1] - times[i]), 0, 1)
    return float(values[i] + (values[i + 1] - values[i]) * u * u * (3 - 2 * u))


def _gate(spans: list[tuple[float, float]], t: float, ramp: float) -> float:
    """Return 1 inside the spans, with smooth ramps of `ramp` seconds at both ends."""
    best = max(min(t - a, b - t) for a, b in spans)
    u = np.clip(best / ramp + 0.5, 0, 1)
    return float(u * u * (3 - 2 * u))


def _bump(u: float) -> float:
    """Return a raised cosine: 1 at 0, 0 beyond -1 and 1."""
    return float(0.5 + 0.5 * np.cos(np.pi * np.clip(u, -1, 1)))


def mouth(t: float) -> tuple[float, float, float]:
    """Return (close, jaw, narrow) at t seconds."""
    jaw = sum(j * _bump((t - c) / w) for c, w, j, _ in SYLLABLES)
    narrow = sum(n * _bump((t - c) / (1.2 * w)) for c, w, _, n in SYLLABLES)
    speaking, smiling = _gate(PHRASES, t, 0.2), _gate(SMILES, t, 0.35)
    close = 1 - 0.45 * speaking * min(1.0, 0.4 + jaw) - smiling
    return float(np.clip(close, 0, 1)), float(min(jaw, 1.0)), float(np.clip(narrow, -1, 1))


def _blink(t: float) -> float:
    """Return how far the lids are down. They close within two frames and open within four."""
    shut = 0.0
    for start in BLINKS:
        u = (t - start) * FPS
        shut = max(shut, min(np.clip(u / 2.2, 0, 1), np.clip((6.2 - u) / 3.4, 0, 1)))
    return float(shut * shut * (3 - 2 * shut))


def state(t: float) -> State:
    """Return the state at t seconds."""
    close, jaw, narrow = mouth(t)
    calm = _gate([(0.4, 9.6)], t, 0.8)  # the clip begins and ends at rest

    def wave(hz: float, phase: float) -> float:
        return calm * float(np.sin(2 * np.pi * (hz * t + phase)))

    pose = Pose(
        yaw=_track(TURNS, t) + 0.5 * wave(0.93, 0.1),
        pitch=_track(NODS, t) + 0.5 * wave(1.31, 0.4) - 0.8 * jaw,
        roll=_track(TILTS, t) + 0.3 * wave(0.71, 0.2),
        x=0.55 * _track(TURNS, t) + 1.2 * wave(0.43, 0.0),
        y=0.5 * _track(NODS, t) + 1.0 * wave(0.61, 0.3),
    )
    camera = (3 * np.sin(0.9 * t), 2 * np.sin(0.7 * t), 1 + 0.035 * _track([(0, 0), (10, 1)], t))
    gaze = -0.6 * pose.yaw + _track(GLANCES, t)  # mostly towards the camera
    gain = 1 + 0.02 * np.sin(2 * np.pi * t / 7.3) + 0.012 * np.sin(2 * np.pi * t / 3.1)
    return State(pose, close, jaw, narrow, _blink(t), gaze, _track(BROWS, t), float(gain), camera)
