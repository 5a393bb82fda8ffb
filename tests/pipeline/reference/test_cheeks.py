"""The cheeks of a photo: one device for all photos of a process, whatever thread reads them."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from makeup_video.pipeline.reference import cheeks
from makeup_video.pipeline.reference.cheeks import see_cheeks
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.opencl import once_a_process
from people import portrait
from reference_photos import face


def portrait_at(scale: float):
    """The portrait, darker by a factor."""
    rgb8 = (portrait() * scale).astype(np.uint8)
    return neutral_face(rgb8, face(), photo_light(rgb8, face()))


@pytest.fixture
def opened(monkeypatch):
    """The devices that are opened in a test, which begins without one."""
    devices, really_open = [], cheeks.open_device

    def opening(*choice):
        devices.append(really_open(*choice))
        return devices[-1]

    monkeypatch.setattr(cheeks, "open_device", opening)
    monkeypatch.setattr(cheeks, "_shared_kernel", once_a_process(cheeks._shared_kernel.__wrapped__))
    return devices


def test_photos_share_a_device(opened):
    for scale in (1.0, 0.8, 0.6):
        assert see_cheeks(portrait_at(scale)) is not None
    assert len(opened) == 1


def test_threads_that_read_photos_at_once_do_not_mix_them_up(opened):
    photos = [portrait_at(scale) for scale in (1.0, 0.8, 0.6, 0.4)] * 5
    alone = [see_cheeks(photo) for photo in photos]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(see_cheeks, photos))
    assert len(opened) == 1
    for one, other in zip(alone, together, strict=True):
        assert (one.roots == other.roots).all() and (one.skin == other.skin).all()
