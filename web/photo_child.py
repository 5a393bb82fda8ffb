"""The process that decodes one visitor's photo: see read_apart.py.

    python -m makeup_video.web.photo_child < (the name as JSON, a newline, the photo's file)

Writes a line of JSON: either [height, width], followed by the pixels, or the reason why the photo
is refused. The process imports little, since the visitor waits while it starts: no face nets, no
OpenCL, no video library.
"""

import json
import sys

from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.images.photo_file import read_photo
from PIL import AvifImagePlugin, Image

# Phones take photos of up to 50.3 million pixels as HEIC, and of 201 million as JPEG. A JPEG is
# averaged to a smaller size while it is decoded.
MOST_PX = 52_000_000
MOST_JPEG_PX = 220_000_000
# Limits on address space. Before the size can be checked, Pillow's WebP decoder reserves 8 bytes
# per pixel of the size in the header, at most 2.1 GB. It touches that memory only when it decodes.
_OPENING_BYTES = 3_000_000_000
# The largest pictures, WebP with transparency, need almost as much.
_DECODING_BYTES = 1_000_000_000
# Threads of the AVIF decoder. With a thread for each core of a large machine, the stacks alone
# would exceed the limit.
_THREADS = 2
_PROCESSOR_SECONDS = 20


def main() -> None:
    name = json.loads(sys.stdin.buffer.readline())
    photo = sys.stdin.buffer.read()
    _limit("RLIMIT_CPU", _PROCESSOR_SECONDS)  # holds even when the parent process is gone
    _limit("RLIMIT_FSIZE", 0)  # a photo stays in memory
    _limit("RLIMIT_AS", _OPENING_BYTES)
    AvifImagePlugin.DEFAULT_MAX_THREADS = _THREADS
    Image.MAX_IMAGE_PIXELS = None  # our own limit is lower, and its message names the size
    out = sys.stdout.buffer
    try:
        rgb8 = read_photo(
            photo,
            name,
            MOST_PX,
            lambda: _limit("RLIMIT_AS", _DECODING_BYTES),
            MOST_JPEG_PX,
        )
    except MakeupVideoError as error:
        out.write(json.dumps(str(error)).encode() + b"\n")
    else:
        out.write(json.dumps(rgb8.shape[:2]).encode() + b"\n")
        out.write(rgb8.data)
    out.flush()


def _limit(name: str, most: int) -> None:
    """Set a limit of the process. Windows has no limits, and macOS ignores the limit on memory."""
    try:
        import resource

        kind = getattr(resource, name)
        resource.setrlimit(kind, (most, resource.getrlimit(kind)[1]))
    except (ImportError, AttributeError, OSError, ValueError):
        return  # the system lacks this limit, or a lower limit stays


if __name__ == "__main__":
    main()
