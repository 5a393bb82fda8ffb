"""The encoders that this machine's FFmpeg has."""

import av
from makeup_video.pipeline.media.codecs import CODECS


def encoders_found() -> dict[str, str]:
    """By codec, as `CODECS` names it, the encoder that FFmpeg has for it; missing ones left out."""
    return {
        name: codec.encoder
        for name, codec in CODECS.items()
        if codec.encoder in av.codecs_available
    }


def ffmpeg_version() -> str:
    """The version of the FFmpeg in PyAV, such as "8.0"."""
    return str(av.ffmpeg_version_info)
