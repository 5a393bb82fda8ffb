"""Faces that stand on their head, which the nets often take for upright ones."""

from makeup_video.pipeline.faces.landmarks import FaceLandmarks, detect, locate
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.similarity import Similarity, middle_of
from makeup_video.pipeline.frames.views import Picture

# Probabilities of a visible mouth: less in a face that may stand on its head, and more in the
# same face the right way up.
_MOUTH_HIDDEN, _MOUTH_SEEN = 0.2, 0.5


class UpsideDown:
    """The faces of a picture that stand on their head.

    Half of them are found, but as if they were upright. The picture is searched once, when a face
    with a hidden mouth is asked about.
    """

    def __init__(
        self, nets: FaceNets, picture: Picture, sides_px: tuple[int, ...], average: bool = False
    ) -> None:
        """sides_px: as of `detect`. average: as of `locate`."""
        self.nets, self.picture, self.sides_px, self.average = nets, picture, sides_px, average
        self._detections: list[Similarity] | None = None

    def right_way_up(self, found: FaceLandmarks) -> FaceLandmarks:
        """The face, or the same face turned by 180 degrees when only then its mouth is seen."""
        if found.scores[1] >= _MOUTH_HIDDEN:
            return found
        if self._detections is None:
            self._detections = detect(self.nets, self.picture, self.sides_px, tilt_degrees=180)
        for detection in self._detections:
            if not _is_within(found, detection):
                continue
            other = locate(self.nets, self.picture, detection, self.average)
            if (
                other is not None
                and other.scores[1] > _MOUTH_SEEN
                and _is_within(found, other.pose)
            ):
                return other
        return found


def _is_within(found: FaceLandmarks, pose: Similarity) -> bool:
    """Whether the middle of another face lies in the box around this one."""
    middle, across, down = middle_of(pose), found.xy.real, found.xy.imag
    return bool(across.min() < middle.real < across.max() and down.min() < middle.imag < down.max())
