"""Shared by tests of the renderer's laws: colours, and scenes of the sample."""

from functools import cache

import av
import numpy as np
from makeup import inside, paint_planes, scene_of
from makeup_video.kernels.colour import to_xyz
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.finishes import product as finished
from makeup_video.pipeline.look.look import Look
from people import SAMPLES, TICK
from skimage.color import xyz2lab

# The true points of this sample are known; scenes have the faces that the product finds.
SAMPLE = SAMPLES / "in.mp4"
GAPING_MOUTHS = (193, 200)
OPEN_MOUTHS = (60, 100, 110, *GAPING_MOUTHS)
WORN = Look(
    lips=finished((180, 0, 46), "matte"), eyes=finished((0, 60, 160), "matte", "eyes"), zone="full"
)


def lab(linear):
    """CIE Lab of linear light in BT.709's primaries, (..., 3)."""
    return xyz2lab(np.maximum(linear, 0) @ to_xyz(1).T, illuminant="D65", observer="2")


def same(left, right):
    return all(np.array_equal(a, b) for a, b in zip(left, right, strict=True))


def sample_frames(first, last):
    with av.open(str(SAMPLE)) as container:
        for number, picture in enumerate(container.decode(video=0)):
            if number > last:
                return
            if number >= first:
                yield Frame(picture, number, TICK, ColourTags(1, 1, 1, 1))


@cache
def sample_scenes():
    """Frame number -> scene of a 1280 x 720 frame."""
    wanted = {*OPEN_MOUTHS, 185}
    return {
        frame.pts: scene_of(frame, find_faces_in_frame(frame)[0].faces)
        for frame in sample_frames(min(wanted), max(wanted))
        if frame.pts in wanted
    }


def true_px(number):
    stored = np.load(SAMPLES / "in_points.npz")
    return stored["points"][number].astype(float) * float(stored["unit"])


def share_changed(number, contour, shrunk_px, look, codes=2):
    """Share of the pixels at least shrunk_px inside a contour whose luma changed by more than
    some codes."""
    scene = sample_scenes()[number]
    old, new = scene.frame.planes[0].astype(int), paint_planes(scene, look)[0]
    within = inside(true_px(number)[contour], old.shape, shrunk_px)
    assert (np.abs(new - old) > 2).any()
    return (np.abs(new - old) > codes)[within].mean()
