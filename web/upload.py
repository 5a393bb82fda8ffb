"""What a page uploads, a photo or a look: the body of a POST, kept in memory alone."""

import asyncio
import re
from urllib.parse import unquote

from makeup_video.web.session import PHOTO_BYTES
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request

LOOK_BYTES = 64 * 1024  # a look with all its layers is 5 kB
_SECONDS = 60  # for the whole body
_SILENT_SECONDS = 10  # between two parts: a stalled upload must not keep others waiting
# A body that is too large is read and discarded up to this size, since a browser that is cut off
# while it sends never sees the response.
_THROWN_AWAY = 4 * PHOTO_BYTES
# Characters that have no place in one line: controls, line ends, direction marks, lone surrogates.
_UNPRINTABLE = re.compile(
    "[\x00-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
_LONGEST_NAME = 80
AT_ONCE = 2  # one photo is read while the next one arrives


class Uploads:
    """Limits how many photos are in memory."""

    def __init__(self) -> None:
        self._now = 0

    def __enter__(self) -> None:
        if self._now >= AT_ONCE:
            raise HTTPException(503, "other photos are being read: try again in a moment")
        self._now += 1

    def __exit__(self, *_: object) -> None:
        self._now -= 1


async def read_body(
    request: Request, most_bytes: int = PHOTO_BYTES, what: str | None = None
) -> bytes:
    """Read the body. what: names it in messages; None: by the name of its file.

    Raises HTTPException: 413 when it is too large, 408 when it is too slow.
    """
    declared = request.headers.get("content-length", "0")
    is_number = declared.isascii() and declared.isdigit()
    too_large = not is_number or int(declared[:18]) > most_bytes
    data = bytearray()
    size = 0
    try:
        async with asyncio.timeout(_SECONDS), asyncio.timeout(_SILENT_SECONDS) as silent:
            async for chunk in request.stream():
                silent.reschedule(asyncio.get_running_loop().time() + _SILENT_SECONDS)
                size += len(chunk)
                too_large = too_large or size > most_bytes
                if too_large:
                    data.clear()
                else:
                    data += chunk
                if size > _THROWN_AWAY:
                    break
    except TimeoutError:
        raise HTTPException(408, "the upload was too slow: try again") from None
    except ClientDisconnect:
        raise HTTPException(400, "the photo did not arrive completely") from None
    if too_large:
        raise HTTPException(
            413,
            f"{what or file_name(request)} is larger than {most_bytes / 1e6:.2g} MB: make it "
            "smaller",
        )
    return bytes(data)


def file_name(request: Request) -> str:
    """Read the file's name from X-File-Name, percent-encoded: one line without a path."""
    name = unquote(request.headers.get("x-file-name", ""))
    name = _UNPRINTABLE.sub("", re.split(r"[/\\]", name)[-1]).strip()
    if len(name) > _LONGEST_NAME:
        name = name[: _LONGEST_NAME // 2 - 1] + "…" + name[-_LONGEST_NAME // 2 :]
    return name or "the photo"
