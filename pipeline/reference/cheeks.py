"""The cheeks of a photo, and bare cheeks: how each place differs from the face's plain skin."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock

import cv2
import numpy as np
from makeup_video.kernels.face import FaceKernel
from makeup_video.kernels.program import Device
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.frames.frame import coding_of
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.frames.sampling import warp
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.reference.product_film import ProductFilm
from makeup_video.pipeline.render.opencl import once_a_process, open_device
from makeup_video.pipeline.render.surfaces.face import face_kernel, face_surface

# The map of bare cheeks: the ranges of `across` and `down` that it spans, in IOD of the mean face,
# and its cells along a side. Both cheeks share the map, so `across` is a distance from the middle.
ACROSS, DOWN, SIDE = (0.0, 1.1), (-0.15, 0.85), 32
# Where blush may lie, in IOD of the mean face.
_NEAR_ACROSS, _NEAR_DOWN = (0.2, 0.85), (0.02, 0.65)
_KNOWN = 0.5  # a node counts only where bare faces are known better than this
_BLUR_PX = 1.5  # sigma, px of the neutral face
_UNLIKE_SKIN = 0.3  # weight of a node that is visible but unlike skin: it may be blush, or hair
# How much a blush of opacity 1 covers, and how much of its own root it adds, as measured on bare
# faces by training/worn/bare_skin.py.
COVER, RESPONSE = 0.89, 0.91
_KIND = KINDS["blush"]


@dataclass(frozen=True, slots=True, eq=False)
class Cheeks:
    """Nodes of the face's surface; each array is (40, 40).

    roots: (40, 40, 3), of shares of skin.  across, down: as in FaceFields.
    skin: 0..1, how visible a node is and how much like skin.
    visible: 0..1, how visible a node is, whatever its colour.
    """

    roots: np.ndarray
    across: np.ndarray
    down: np.ndarray
    skin: np.ndarray
    visible: np.ndarray

    def cells(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the nodes lie in a map of SIDE x SIDE cells, as float32 x and y."""
        x = (np.abs(self.across) - ACROSS[0]) * (SIDE / (ACROSS[1] - ACROSS[0])) - 0.5
        y = (self.down - DOWN[0]) * (SIDE / (DOWN[1] - DOWN[0])) - 0.5
        return x.astype(np.float32), y.astype(np.float32)

    def made_up(self) -> np.ndarray:
        """(40, 40) the weight of each node when blush is worn: strong blush is unlike skin."""
        seen: np.ndarray = np.maximum(self.skin, _UNLIKE_SKIN * self.visible)
        counted: np.ndarray = seen * self._may_blush()
        return counted

    def weights(self) -> np.ndarray:
        """(40, 40) the weight of each node: how much it shows skin, where blush may lie; else 0."""
        counted: np.ndarray = self.skin * self._may_blush()
        return counted

    def _may_blush(self) -> np.ndarray:
        return self.within(_NEAR_ACROSS, _NEAR_DOWN, _KNOWN)

    def within(
        self, across: tuple[float, float], down: tuple[float, float], known: float
    ) -> np.ndarray:
        """(40, 40) bool: the nodes in these ranges where bare faces are known well enough.

        across: distances from the middle of the face.  down: as in FaceFields.  known: see `known`.
        """
        beside = np.abs(self.across)
        near = (beside > across[0]) & (beside < across[1])
        near &= (self.down > down[0]) & (self.down < down[1])
        there: np.ndarray = near & (self.known() > known)
        return there

    def known(self) -> np.ndarray:
        """(40, 40) how well bare faces are known at each node, 0..1."""
        known: np.ndarray = cv2.remap(_bare()[..., 3], *self.cells(), cv2.INTER_LINEAR)
        return known

    def mean(self) -> np.ndarray:
        """(3,) the mean root where blush may lie."""
        weights = self.weights()
        total = max(float(weights.sum()), 1e-6)
        mean: np.ndarray = np.einsum("hw,hwc->c", weights, self.roots) / total
        return mean

    def film(self) -> ProductFilm:
        """Bare cheeks at these nodes, and how blush shows on them."""
        bare = cv2.remap(_bare()[..., :3], *self.cells(), cv2.INTER_LINEAR)
        even = np.ones(bare.shape[:2], np.float32)
        return ProductFilm(bare, even * np.float32(COVER), even * np.float32(RESPONSE))


def density(cheeks: Cheeks, shape: Mapping[str, float]) -> np.ndarray:
    """How densely a blush of this shape lies on each node: float32, 0..1, shaped like `skin`."""
    fields = FaceFields(cheeks.across[None], cheeks.down[None])
    (coat,) = _KIND.coats(fields, _plain(), _KIND.whole_shape(shape))
    dense = np.ones(1, np.float32) if coat.density is None else coat.density
    on_nodes: np.ndarray = np.broadcast_to(dense, (1, *cheeks.skin.shape))[0]
    return on_nodes


def see_cheeks(neutral: NeutralFace) -> Cheeks | None:
    """The cheeks of a photo; None for a face that is too small, or seen from the side."""
    frame = to_frame(np.ascontiguousarray(neutral.rgb8[..., ::-1]))
    _, kernel, lock = _shared_kernel()
    with lock:
        made = face_surface(neutral.face, frame, coding_of(frame), kernel)
    if made is None:
        return None
    surface = made[0]
    soft = cv2.GaussianBlur(neutral.linear, (0, 0), _BLUR_PX)
    roots = neutral.roots(warp(soft, surface.grid.to_px, surface.grid.size_wh))
    skin = surface.visible * surface.likeness
    return Cheeks(roots, surface.across, surface.down, skin, surface.visible)


@once_a_process
def _shared_kernel() -> tuple[Device, FaceKernel, Lock]:
    """The kernel that makes the surfaces of faces, its device, and a lock: one thread at a time.

    The device is returned because the kernel does not keep it alive. Opening a device for each
    photo would take a hundred times as long as the kernel.
    """
    device = open_device()
    return device, face_kernel(device), Lock()


@lru_cache(maxsize=1)
def _plain() -> GraphicsParams:
    """A blush of any colour, since densities do not depend on the colour."""
    return product(_KIND.first_rgb, _KIND.first_finish, _KIND.part)


@lru_cache(maxsize=1)
def _bare() -> np.ndarray:
    """(32, 32, 4): roots of bare cheeks, and how well each cell is known."""
    return read_array("bare_cheeks.npy").astype(np.float32)
