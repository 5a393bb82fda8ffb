"""Requests that the end of the server cuts off are answered, with the reason."""

import asyncio

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

STOPPING = "makeup-video is stopping"


class AnswerCutOff:
    """An application whose requests get status 503 when the server cancels them as it stops.

    uvicorn would answer them with 500, as if something were wrong.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request or a WebSocket. When it is cancelled, raises CancelledError for a
        WebSocket, for a request whose answer has begun, and for a client that does not read."""
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
            # One step, which takes all of it unless the client does not read. uvicorn cancels
            # once, so whoever waited for such a client now would keep the server from ending.
            try:
                answer.send(None)
            except StopIteration:
                return
            answer.close()
            raise
