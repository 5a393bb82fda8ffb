"""Faces that stand on their head, which the nets often take for upright ones."""

from makeup_video.pipeline.faces.landmarks import FaceLandmarks, detect, locate
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.similarity import middle_of
from makeup_video.pipeline.frames.views import Picture

# Probabilities of a visible mouth: less in a face that may stand on its head, and more in the
# same face the right way up.
_MOUTH_HIDDEN, _MOUTH_SEEN = 0.2, 0.5


def right_way_up(
    nets: FaceNets,
    picture: Picture,
    found: FaceLandmarks,
    sides_px: tuple[int, ...],
    average: bool = False,
) -> FaceLandmarks:
    """The face, or the same face turned by 180 degrees when only then its mouth is seen.

    Half of all faces that stand on their head are found, but as if they were upright. sides_px: as
    of `detect`. average: as of `locate`.
    """
    if found.scores[1] >= _MOUTH_HIDDEN:
        return found
    for detection in detect(nets, picture, sides_px, tilt_degrees=180):
        other = locate(nets, picture, detection, average)
        if other is not None and other.scores[1] > _MOUTH_SEEN and _is_within(found, other):
            return other
    return found


def _is_within(found: FaceLandmarks, other: FaceLandmarks) -> bool:
    """Whether the middle of the other face lies in the box around this one."""
    middle = middle_of(other.pose)
    across, down = found.xy.real, found.xy.imag
    return bool(across.min() < middle.real < across.max() and down.min() < middle.imag < down.max())
