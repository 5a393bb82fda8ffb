"""Requests that the end of the server cuts off: each is answered, with the reason."""

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
        """Serve a request or a WebSocket. Raises CancelledError where it is too late to answer."""
        has_begun = False

        async def sending(message: Message) -> None:
            nonlocal has_begun
            has_begun = True
            await send(message)

        try:
            await self._app(scope, receive, sending)
        except asyncio.CancelledError:
            if has_begun or scope["type"] != "http":
                raise
            await JSONResponse({"error": STOPPING}, 503)(scope, receive, send)
