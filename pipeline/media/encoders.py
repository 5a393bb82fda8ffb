"""The encoders that this machine's FFmpeg has."""

import av
from makeup_video.pipeline.media.codecs import CODECS


def encoders_found() -> dict[str, str]:
    """FFmpeg's encoder by the codec's name in `CODECS`; codecs without an encoder are left out."""
    return {
        name: codec.encoder
        for name, codec in CODECS.items()
        if codec.encoder in av.codecs_available
    }


def ffmpeg_version() -> str:
    """The version of the FFmpeg in PyAV, such as "8.0"."""
    return str(av.ffmpeg_version_info)
