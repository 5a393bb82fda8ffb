"""Answers, with the reason, the requests that are cut off when the server stops."""

import asyncio

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

STOPPING = "makeup-video is stopping"


class AnswerCutOff:
    """An application whose requests get status 503 when the server stops and cancels them.

    uvicorn would answer these requests with status 500, as if something were wrong.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request or a WebSocket.

        Once cancelled, it raises CancelledError if it serves a WebSocket, if the answer of the
        request has begun, or if the client does not read.
        """
        has_begun = False

        async def sending(message: Message) -> None:
            nonlocal has_begun
            await send(message)
            has_begun = True

        try:
            await self._app(scope, receive, sending)
        except asyncio.CancelledError:
            if has_begun or scope["type"] != "http":
                raise
            answer = JSONResponse({"error": STOPPING}, 503)(scope, receive, send)
            # One step sends the whole answer unless the client does not read. uvicorn cancels only
            # once, so waiting for such a client here would keep the server from stopping.
            try:
                answer.send(None)
            except StopIteration:
                return
            answer.close()
            raise
