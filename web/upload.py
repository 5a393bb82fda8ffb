"""Uploads from a page: a photo, look or catalogue in the body of a POST, kept only in memory."""

import asyncio
import re
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar
from urllib.parse import unquote

from makeup_video.web.session import PHOTO_BYTES
from makeup_video.web.slow_jobs import SlowJobs
from makeup_video.web.waiting import while_wanted
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request

LOOK_BYTES = 64 * 1024  # a look with all its layers is 5 kB
_SECONDS = 60  # for the whole body
_SILENT_SECONDS = 10  # between two parts: a stalled upload must not keep others waiting
# A body that is too large is read and discarded up to this size, since a browser that is cut off
# while it sends never sees the response.
_THROWN_AWAY = 4 * PHOTO_BYTES
# Characters that have no place in one line: controls, line ends, direction marks, characters
# without width, lone surrogates. The joiners (U+200C, U+200D) are not listed, since words and emoji
# contain them.
_UNPRINTABLE = re.compile(
    "[\x00-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060\u2066-\u2069\ufeff\ud800-\udfff]"
)
_LONGEST_NAME = 80
AT_ONCE = 2  # one photo is read while the next one arrives
T = TypeVar("T")


class Uploads:
    """Runs jobs on uploads, and limits how many uploads are in memory at once."""

    def __init__(self, slow_jobs: SlowJobs) -> None:
        self._slow_jobs = slow_jobs
        self._running = 0

    async def run(
        self,
        request: Request,
        job: Callable[[bytes], T],
        most_bytes: int = PHOTO_BYTES,
        what: str | None = None,
    ) -> T:
        """Read the body, and return the job's result.

        When a page gives up its request, as for a newer photo, there is room for another upload. A
        job that has not begun is then left out, and the result of a job that has begun is lost.
        most_bytes, what: see `read_body`. Raises HTTPException, and what the job raises.
        """
        if self._running >= AT_ONCE:
            raise HTTPException(503, "other uploads are being read: try again in a moment")
        self._running += 1
        body = bytearray()
        submitted: Future[T] | None = None

        def work() -> T:
            data = bytes(body)
            body.clear()
            return job(data)

        try:
            body = await read_body(request, most_bytes, what)
            submitted = self._slow_jobs.submit(work)
            return await while_wanted(request, self._slow_jobs.result_of(submitted))
        finally:
            self._running -= 1
            if submitted is not None and submitted.cancel():
                body.clear()  # a job that is left out would keep the body until its turn


async def read_body(
    request: Request, most_bytes: int = PHOTO_BYTES, what: str | None = None
) -> bytearray:
    """Read the body of a request.

    what: what messages call the body; None: they use the name of its file.
    Raises HTTPException: 413 for a body that is too large, 408 for one that is too slow, 400 for
    one that does not arrive completely.
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
        raise HTTPException(
            400, f"{what or file_name(request)} did not arrive completely: send it again"
        ) from None
    if too_large:
        raise HTTPException(
            413,
            f"{what or file_name(request)} is larger than {_size(most_bytes)}: make it smaller",
        )
    return data


def _size(count: int) -> str:
    """A number of bytes, such as "66 kB" or "64 MB"."""
    return f"{count / 1e6:.2g} MB" if count >= 1_000_000 else f"{count / 1e3:.0f} kB"


def without_controls(text: str) -> str:
    """A text from a stranger, without the characters that have no place in one line."""
    return _UNPRINTABLE.sub("", text)


def file_name(request: Request) -> str:
    """Read the file's name from the percent-encoded X-File-Name, as one line without a path."""
    name = unquote(request.headers.get("x-file-name", ""))
    name = without_controls(re.split(r"[/\\]", name)[-1]).strip()
    if len(name) > _LONGEST_NAME:
        name = name[: _LONGEST_NAME // 2 - 1] + "…" + name[-_LONGEST_NAME // 2 :]
    return name or "the photo"
