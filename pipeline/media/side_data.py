"""Which side data of a picture an output cannot keep."""

import av
from makeup_video.pipeline.frames.side_data import side_data
from makeup_video.pipeline.media.codecs import VideoCodec, codecs_with


def lost_side_data(picture: av.VideoFrame, codec: VideoCodec) -> list[str]:
    """What an output of this codec cannot keep of a picture's side data, but for HDR."""
    lost = []
    if not codec.captions and side_data(picture, "A53_CC") is not None:
        others = codecs_with(lambda other: other.captions)
        lost.append(f"closed captions: {codec.name} cannot carry them; use {others}")
    if side_data(picture, "SPHERICAL") is not None:
        lost.append("tags of a 360 degree video: they are not written")
    return lost
