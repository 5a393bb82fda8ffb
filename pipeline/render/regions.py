"""The regions of a face that makeup is painted on: the lips, the eyes, the whole face."""

from typing import TYPE_CHECKING

from makeup_video.pipeline.render.surfaces.eyes import EYES
from makeup_video.pipeline.render.surfaces.face_region import FACE
from makeup_video.pipeline.render.surfaces.lips import LIPS_REGION

if TYPE_CHECKING:
    from makeup_video.pipeline.render.surfaces.region import ReadRegion, Region

# The regions that are read in every frame, in the order of kernels/surface.cl.
READ: "dict[str, ReadRegion]" = {"lips": LIPS_REGION, "eyes": EYES}
# All regions, by the name that a kind of makeup gives in `Kind.region`.
REGIONS: "dict[str, Region]" = {**READ, "face": FACE}
