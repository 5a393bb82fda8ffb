"""Lets requests wait for slow jobs. When a page gives up its request, its job is left out."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, TypeVar

from starlette.exceptions import HTTPException
from starlette.requests import Request

T = TypeVar("T")
Run = Callable[[Callable[[], Any]], Awaitable[Any]]


async def while_wanted(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """Return the result of `work`, which is cancelled when the page gives up the request.

    The body of the request must have been read, if it has one. Raises HTTPException, and what
    `work` raises.
    """
    working = asyncio.ensure_future(work)
    leaving = asyncio.ensure_future(_left(request))
    try:
        await asyncio.wait([working, leaving], return_when=asyncio.FIRST_COMPLETED)
        if not working.done():
            raise HTTPException(400, "the page has given up this request: send it again")
        return working.result()
    finally:
        working.cancel()  # takes effect on the loop's next turn
        leaving.cancel()


class OneAtATime:
    """Runs jobs whose results pages fetch. Only one of these jobs at a time waits for the thread,
    so that a picture or a photo never waits for many of them."""

    def __init__(self, run: Run) -> None:
        """run: the method of SlowJobs that runs a job on the thread."""
        self._run = run
        self._one = asyncio.Lock()

    async def run(self, request: Request, job: Callable[[], T]) -> T:
        """Return the job's result, unless the page has left. Raises as `while_wanted`."""
        return await while_wanted(request, self._in_turn(job))

    async def _in_turn(self, job: Callable[[], T]) -> T:
        async with self._one:
            result: T = await self._run(job)
            return result


async def _left(request: Request) -> None:
    """Wait until the page gives up a request."""
    while (await request.receive())["type"] != "http.disconnect":
        pass
