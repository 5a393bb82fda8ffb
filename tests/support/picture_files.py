"""Picture files with metadata."""

import struct
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.images.picture_file import (
    EXIF,
    ICC_PROFILE,
    XMP,
    Metadata,
    decode_picture,
    read_bytes,
)

ICC = ICC_PROFILE
_NUMBERS = {
    EXIF: cv2.IMAGE_METADATA_EXIF,
    XMP: cv2.IMAGE_METADATA_XMP,
    ICC: cv2.IMAGE_METADATA_ICCP,
}


def exif(orientation, order="<"):
    """A minimal TIFF structure with one tag."""
    mark = b"II*\0" if order == "<" else b"MM\0*"
    head = mark + struct.pack(order + "I", 8)
    return head + struct.pack(order + "HHHIHHI", 1, 0x0112, 3, 1, orientation, 0, 0)


def scene(shape=(40, 60, 3), dtype=np.uint8, seed=0):
    rng = np.random.default_rng(seed)
    small = rng.integers(0, np.iinfo(dtype).max, (5, 5, *shape[2:])).astype(dtype)
    big = cv2.resize(small, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return big.reshape(shape)


def write(path, pixels, metadata=None, options=()):
    metadata = metadata or {}
    kinds = [int(_NUMBERS[kind]) for kind in metadata]
    blobs = [np.frombuffer(data, np.uint8) for data in metadata.values()]
    ok, data = cv2.imencodeWithMetadata(path.suffix, pixels, kinds, blobs, list(options))
    assert ok
    path.write_bytes(data.tobytes())
    return path


def read_picture(path: Path) -> tuple[np.ndarray, Metadata]:
    """Stored pixels and metadata of a picture file, as `decode_picture` gives them."""
    return decode_picture(read_bytes(path), path)
