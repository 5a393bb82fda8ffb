"""Reads which kinds of makeup a face wears, from the face's colours and with a net.

The net sees eyes, face and lips at once. From labelled photos it learned what bare faces look like
in all lights, and from painted faces the numbers of the layers. For each kind, two scales and a
shift turn the log-odds of the net and of the colours (colours.py) into a probability (Platt 1999).
They were fitted on real photos on which neither was trained.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.reference.colours import Colours
from makeup_video.pipeline.reference.makeup_input import makeup_input, mirrored
from makeup_video.pipeline.reference.makeup_numbers import WORN, ReadLayer, from_vector
from makeup_video.pipeline.reference.nets import MAKEUP, reference_net
from makeup_video.pipeline.render.scene import SceneLight

_MOST_ODDS = 15.0
# For each kind: the scale of the net's log-odds, the scale of the colours' log-odds, and the shift,
# as training/worn/evaluate.py prints them. For lipstick that program was given the ratio of the
# scales (`--ratio lips 0.8`): nearly all photos of makeup show lipstick, so free scales would learn
# to distinguish photos of makeup from others.
_CALIBRATION: Mapping[str, tuple[float, float, float]] = {
    "lipstick": (0.364, 0.455, -2.037),
    "eyeshadow": (1.137, 0.487, -0.718),
    "eyeliner": (0.865, 0.542, -2.415),
    "blush": (1.224, 0.479, -0.539),
}
# No labelled face wears green, pale violet or black lipstick, but the net sees it, since it learned
# from painted faces, too. Such lipstick adds to the log-odds in two ways. First, where the net is
# sure although the colours lack red: the net's log-odds lie above the first of these numbers, the
# colours' below the second, and the product of both distances counts times the third. Of 373 bare
# faces three lie there, by little.
_SEEN_BY_NET, _LACKING_RED, _FOR_LACKING = 1.0, -2.0, 2.0
# Second, where the lips are further from bare ones than almost any bare lips are: the distance
# above the first number counts times the second. It counts wholly if the net's log-odds reach 1,
# and not at all if they are below 0.
_FURTHEST_BARE, _FOR_UNLIKE = 4.0, 1.4
# Kinds that are hardly ever worn alone. For each: what other kinds add to its log-odds when they
# are certain; the power of their probability, by which this is multiplied otherwise; and the shift
# without company. These were fitted on the same photos. Certain eyeshadow is evidence for a
# lipstick as pale as bare lips, while eyes that may be made up say nothing about lips.
_COMPANY: Mapping[str, tuple[Mapping[str, float], float, float]] = {
    "lipstick": ({"eyeshadow": 4.0}, 8.0, 0.0),
    "eyeshadow": ({"lipstick": 3.0, "blush": 3.0}, 0.5, -2.32),
    "blush": ({"lipstick": 1.5, "eyeshadow": 0.75}, 0.5, -1.2),
}
# A kind counts as worn from this probability on. On real photos, at most about one bare face in
# seven is then read as wearing a kind.
WORN_FROM: Mapping[str, float] = {
    "lipstick": 0.3,
    "eyeshadow": 0.125,
    "eyeliner": 0.17,
    "blush": 0.042,
}


@dataclass(frozen=True, slots=True)
class Makeup:
    """The makeup that is read from a face.

    worn: for each kind, the probability that it is worn.
    layers: for each kind and slot, the layer as the net reads it, even if the kind is not worn.
    """

    worn: Mapping[str, float]
    layers: Mapping[tuple[str, str], ReadLayer]


def read_makeup(rgb8: np.ndarray, face: Face, light: SceneLight, colours: Colours) -> Makeup:
    """Read which makeup a face wears. Raises InstallError without the net.

    rgb8: (H, W, 3) uint8, R'G'B' as sRGB encodes it.
    The net's numbers are the mean over the face and its mirror image, which wear the same makeup.
    """
    seen = makeup_input(rgb8, face, light)
    found = reference_net(MAKEUP)(np.stack([seen, mirrored(seen)]))
    odds = zip(WORN, found["log_odds"].mean(0).tolist(), colours.log_odds().tolist(), strict=True)
    away = colours.flat_lips.away()
    worn = {kind: probability(kind, by_net, by_colours, away) for kind, by_net, by_colours in odds}
    worn |= {kind: in_company(kind, worn) for kind in _COMPANY}
    layers = from_vector(found["numbers"].mean(0))
    return Makeup(worn, {(layer.kind, layer.slot): layer for layer in layers})


def probability(kind: str, by_net: float, by_colours: float, away: float = 0.0) -> float:
    """The probability that a kind is worn, from the log-odds of the net and of the colours.

    away: how far the lips are from bare ones, from FlatLips.away; only lipstick depends on it.
    """
    net, colours, shift = _CALIBRATION[kind]
    more = _for_unusual(by_net, by_colours, away) if kind == "lipstick" else 0.0
    return _share(net * by_net + colours * by_colours + shift + more)


def _for_unusual(by_net: float, by_colours: float, away: float) -> float:
    """What a lip colour that no labelled face wears adds to the log-odds of lipstick."""
    lacking = max(by_net - _SEEN_BY_NET, 0.0) * max(_LACKING_RED - by_colours, 0.0)
    unlike = min(max(by_net, 0.0), 1.0) * max(away - _FURTHEST_BARE, 0.0)
    return _FOR_LACKING * lacking + _FOR_UNLIKE * unlike


def in_company(kind: str, worn: Mapping[str, float]) -> float:
    """The probability of a kind of _COMPANY, given the other kinds that are worn.

    For example, hardly any labelled face with clear eyeshadow has bare lips.
    worn: for each kind, its probability by itself.
    """
    adds, power, shift = _COMPANY[kind]
    beside = sum(most * worn[other] ** power for other, most in adds.items())
    return _share(math.log(worn[kind] / (1 - worn[kind])) + beside + shift)


def _share(odds: float) -> float:
    """Log-odds -> a probability, which is never 0 or 1."""
    return 1 / (1 + math.exp(-min(max(odds, -_MOST_ODDS), _MOST_ODDS)))
