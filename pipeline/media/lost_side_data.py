"""Which side data of a picture an output cannot keep."""

import sys

import av
from makeup_video.pipeline.frames.side_data import side_data
from makeup_video.pipeline.media.codecs import VideoCodec, codecs_with

# Side data that no encoder and no muxer of ours writes, in words.
_NOT_WRITTEN = {
    "SPHERICAL": "tags of a 360 degree video: they are not written",
    "AMBIENT_VIEWING_ENVIRONMENT": "ambient viewing environment: it is not written",
}
# Of FFmpeg's AVStereo3DType: one picture for both eyes, and the kinds that H.264 has no number for.
_MONO, _UNNUMBERED = 0, (5, 8)


def lost_side_data(picture: av.VideoFrame, codec: VideoCodec) -> list[str]:
    """What an output of this codec cannot keep of a picture's side data, apart from HDR."""
    lost = []
    if not codec.captions and side_data(picture, "A53_CC") is not None:
        others = codecs_with(lambda other: other.captions)
        lost.append(f"closed captions: {codec.name} cannot carry them; use {others}")
    if _loses_stereo(side_data(picture, "STEREO3D"), codec):
        others = codecs_with(lambda other: other.stereo)
        lost.append(f"tags of a stereo 3D video: {codec.name} cannot carry them; use {others}")
    lost += [words for name, words in _NOT_WRITTEN.items() if side_data(picture, name) is not None]
    return lost


def _loses_stereo(data: bytes | None, codec: VideoCodec) -> bool:
    """data: FFmpeg's AVStereo3D, whose first field says how the views are packed; or None."""
    kind = _MONO if data is None else int.from_bytes(data[:4], sys.byteorder)
    return kind != _MONO and (not codec.stereo or kind in _UNNUMBERED)
