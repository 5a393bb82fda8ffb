"""What FFmpeg hands over beside the samples of a picture."""

from typing import Any

import av
from av.sidedata.sidedata import Type as SideDataType
from makeup_video.pipeline.media.codecs import VideoCodec, codecs_with


def side_data(picture: av.VideoFrame, name: str) -> bytes | None:
    """The bytes of one kind of FFmpeg's frame side data; None when the frame has none."""
    everything: Any = picture.side_data
    data = everything.get(SideDataType[name])
    return None if data is None else bytes(data)


def lost_side_data(picture: av.VideoFrame, codec: VideoCodec) -> list[str]:
    """What an output of this codec cannot keep of a picture's side data, but for HDR."""
    lost = []
    if not codec.captions and side_data(picture, "A53_CC") is not None:
        others = codecs_with(lambda other: other.captions)
        lost.append(f"closed captions: {codec.name} cannot carry them; use {others}")
    if side_data(picture, "SPHERICAL") is not None:
        lost.append("tags of a 360 degree video: they are not written")
    return lost
