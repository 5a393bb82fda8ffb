"""Reads which kinds of makeup a face wears, from its colours and with a net.

The net sees eyes, face and lips at once; it learned from labelled photos what bare faces look like,
in all lights, and from painted faces the numbers of the layers. Its log-odds and those of the
colours (colours.py) become probabilities by two scales and a shift for each kind (Platt 1999),
fitted on real photos that neither was trained on.
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
# By kind: the scales of the net's and of the colours' log-odds, and the shift, as
# training/worn/evaluate.py prints them. For lipstick the ratio of the scales is given to it
# (`--ratio lips 0.8`): nearly all photos of makeup show lipstick, and free scales would learn
# to distinguish those photos from others.
_CALIBRATION: Mapping[str, tuple[float, float, float]] = {
    "lipstick": (0.364, 0.455, -2.037),
    "eyeshadow": (1.137, 0.487, -0.718),
    "eyeliner": (0.865, 0.542, -2.415),
    "blush": (1.224, 0.479, -0.539),
}
# Green, pale violet, black: no labelled face wears such lipstick, but the net, which learned from
# painted faces, too, sees it. It counts in two ways. Where the net is sure though the colours lack
# red: from these log-odds of both on, by the product of what exceeds them; of 373 bare faces three
# lie there, by little. And by how much further the lips are from bare ones than those hardly ever
# are: all of it where the net's log-odds reach 1, nothing where they are below 0.
_SEEN_BY_NET, _LACKING_RED, _FOR_LACKING = 1.0, -2.0, 2.0
_FURTHEST_BARE, _FOR_UNLIKE = 4.0, 1.4
# Kinds that are hardly ever worn alone: what each other kind adds to their log-odds where it is
# certain, the power of its probability of which it adds that much otherwise, and the shift without
# company. Fitted on the same photos. Certain eyeshadow is evidence for a lipstick as pale as bare
# lips; eyes that may be made up say nothing about lips.
_COMPANY: Mapping[str, tuple[Mapping[str, float], float, float]] = {
    "lipstick": ({"eyeshadow": 4.0}, 8.0, 0.0),
    "eyeshadow": ({"lipstick": 3.0, "blush": 3.0}, 0.5, -2.32),
    "blush": ({"lipstick": 1.5, "eyeshadow": 0.75}, 0.5, -1.2),
}
# Probabilities from which a kind counts as worn: on real photos about one bare face in seven is
# read as worn at most.
WORN_FROM: Mapping[str, float] = {
    "lipstick": 0.3,
    "eyeshadow": 0.125,
    "eyeliner": 0.17,
    "blush": 0.042,
}


@dataclass(frozen=True, slots=True)
class Makeup:
    """What a net reads from a face.

    worn: by kind, the probability that it is worn.
    layers: by kind and slot, with the numbers that the net returns, worn or not.
    """

    worn: Mapping[str, float]
    layers: Mapping[tuple[str, str], ReadLayer]


def read_makeup(rgb8: np.ndarray, face: Face, light: SceneLight, colours: Colours) -> Makeup:
    """rgb8: (H, W, 3) uint8, R'G'B' as sRGB encodes it.  Raises InstallError without the net.

    The mean over the face and its mirror image, which wear the same.
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
    """That a kind is worn, from both log-odds.

    away: how far the lips are from bare ones, as of FlatLips; only lipstick depends on it.
    """
    net, colours, shift = _CALIBRATION[kind]
    more = _for_unusual(by_net, by_colours, away) if kind == "lipstick" else 0.0
    return _share(net * by_net + colours * by_colours + shift + more)


def _for_unusual(by_net: float, by_colours: float, away: float) -> float:
    """What lips in a colour that no labelled face wears add to the log-odds of lipstick."""
    lacking = max(by_net - _SEEN_BY_NET, 0.0) * max(_LACKING_RED - by_colours, 0.0)
    unlike = min(max(by_net, 0.0), 1.0) * max(away - _FURTHEST_BARE, 0.0)
    return _FOR_LACKING * lacking + _FOR_UNLIKE * unlike


def in_company(kind: str, worn: Mapping[str, float]) -> float:
    """The probability of a kind of _COMPANY beside what else is worn: of the labelled faces with
    clear eyeshadow hardly one has bare lips.

    worn: by kind, the probability of each by itself.
    """
    adds, power, shift = _COMPANY[kind]
    beside = sum(most * worn[other] ** power for other, most in adds.items())
    return _share(math.log(worn[kind] / (1 - worn[kind])) + beside + shift)


def _share(odds: float) -> float:
    """Log-odds as a probability, which is never 0 or 1."""
    return 1 / (1 + math.exp(-min(max(odds, -_MOST_ODDS), _MOST_ODDS)))
