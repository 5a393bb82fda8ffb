"""What FFmpeg hands over beside the samples of a picture."""

from collections.abc import Mapping
from typing import Any

import av
from av.sidedata.sidedata import SideDataContainer
from av.sidedata.sidedata import Type as SideDataType


def all_side_data(picture: av.VideoFrame) -> Mapping[SideDataType, Any]:
    """All frame side data of a picture by kind, each a buffer.

    PyAV's own `picture.side_data` is not used. The picture keeps it, and it refers to the picture,
    so the picture would stay in memory until Python collects garbage.
    """
    new_container: Any = SideDataContainer  # PyAV's stubs have no constructor
    return {data.type: data for data in new_container(picture)}


def side_data(picture: av.VideoFrame, name: str) -> bytes | None:
    """The bytes of one kind of FFmpeg's frame side data; None when the picture has none."""
    data = all_side_data(picture).get(SideDataType[name])
    return None if data is None else bytes(data)
