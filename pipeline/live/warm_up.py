"""Runs every net and kernel once, so that the first frames of a live run are not late.

Without the warm-up the first five frames took 435, 275, 180, 116 and 19 ms when nothing had been
compiled before, and 45, 20, 8, 10 and 10 ms when the kernels had been.
"""

from fractions import Fraction

import av
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.find import DETECTOR_SIDES_PX
from makeup_video.pipeline.faces.landmarks import FaceLandmarks, detect, to_face
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.faces.similarity import Similarity
from makeup_video.pipeline.faces.tracker import BESIDE_SIDES_PX
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.views import FramePicture
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite

_SIZE_WH = 640, 360
_IOD_PX = 80.0  # distance of the outer eye corners


def warm_up(build: BuildScene, paint: Composite) -> None:
    """Look for faces in a grey frame and paint a mean face there, with the run's own stages."""
    frame = _grey()
    picture, nets = FramePicture(frame, 1), load_nets()
    detect(nets, picture, (*DETECTOR_SIDES_PX, *BESIDE_SIDES_PX))
    where = Similarity(_IOD_PX + 0j, complex(_SIZE_WH[0] / 2, _SIZE_WH[1] / 2))
    nets.read_mesh(picture, where)
    mean = nets.mean_face
    xy = where.apply(mean[:, 0] + 1j * mean[:, 1])
    layout = nets.crop_layout(xy)
    parts = nets.read_parts(picture, layout)
    z, centres = _IOD_PX * mean[:, 2], parts.centres
    seen = FaceLandmarks(xy, z, (1, 1), where, parts.lips, layout, centres, centres, 0.0)
    faces = (to_face(seen, picture, 0),)
    scene = build(FrameFaces(frame, faces))
    for count in (1, 2):  # layers of a kind: a kernel has two versions, for one and for several
        look = Look(
            Layer(kind.name, product(kind.first_rgb, "shimmer", kind.part))
            for kind in KINDS.values()
            for _ in range(min(count, kind.most))
        )
        paint.rehearse(scene, look)


def _grey() -> Frame:
    """Make a grey frame in the layout of all live frames."""
    picture = av.VideoFrame(*_SIZE_WH, "yuv420p")
    for plane in picture.planes:
        plane.update(bytes([128]) * plane.buffer_size)
    return Frame(picture, 0, Fraction(1, 30), ColourTags(1, 1, 1, 1))
