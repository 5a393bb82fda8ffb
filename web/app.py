"""The server's endpoints: the page and its files, its WebSocket, uploads, and the picture."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from makeup_video.pipeline.errors import (
    CatalogueError,
    InputError,
    LookError,
    MakeupVideoError,
    StoppedError,
    UsageError,
)
from makeup_video.pipeline.look.ready import ready_looks
from makeup_video.web.answers import (
    look_in,
    ready_looks_message,
    several_faces_message,
    shades_message,
)
from makeup_video.web.cut_off import AnswerCutOff
from makeup_video.web.messages import BYE, error_message
from makeup_video.web.room import Room
from makeup_video.web.rooms import Rooms
from makeup_video.web.same_origin import SameOrigin, is_this_machine
from makeup_video.web.session import SeveralFaces
from makeup_video.web.slow_jobs import SlowJobs
from makeup_video.web.upload import LOOK_BYTES, Uploads, file_name, read_body
from makeup_video.web.viewer import Viewer
from makeup_video.web.waiting import OneAtATime
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

PAGE = Path(__file__).parent / "page"
_KINDS = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
    ".jpg": "image/jpeg",
}
_STATUS = {  # of answers that report an error
    InputError: 422,
    CatalogueError: 422,
    LookError: 400,
    UsageError: 400,
    StoppedError: 503,
}
_JSON = "application/json"
_CATALOGUE_BYTES = 4_000_000  # the largest catalogues have a few thousand rows of 100 bytes
_TRY_AGAIN_LATER = 1013  # close codes of a WebSocket, RFC 6455
_GOING_AWAY = 1001
Log = Callable[[str], None]


def make_app(rooms: Rooms, slow_jobs: SlowJobs, host: str, port: int, log: Log) -> ASGIApp:
    """Make the application that uvicorn serves.

    host: as given to --host.  port: where the server listens.  log: logs internal errors.
    """
    endpoints = Endpoints(rooms, slow_jobs)
    routes = [
        Route("/", endpoints.page, methods=["GET"]),
        Route("/static/{name}", endpoints.static, methods=["GET"]),
        Route("/picture.png", endpoints.picture, methods=["GET"]),
        Route("/looks", endpoints.looks, methods=["GET"]),
        Route("/look-thumbnail", endpoints.look_thumbnail, methods=["POST"]),
        Route("/photo", endpoints.photo, methods=["POST"]),
        Route("/photo-thumbnail", endpoints.photo_thumbnail, methods=["GET"]),
        Route("/portrait", endpoints.portrait, methods=["POST"]),
        Route("/portrait-thumbnail", endpoints.portrait_thumbnail, methods=["GET"]),
        Route("/camera", endpoints.cameras, methods=["GET"]),
        Route("/camera", endpoints.choose_camera, methods=["POST"]),
        Route("/recording", endpoints.recording, methods=["POST"]),
        Route("/shades", endpoints.shades, methods=["POST"]),
        WebSocketRoute("/ws", endpoints.watch),
    ]

    async def internal_error(request: Request, error: Exception) -> Response:
        log(f"internal error at {request.url.path}: {type(error).__name__}: {error}")
        return _error(500, "an internal error; the terminal of makeup-video shows which")

    app = Starlette(
        routes=routes,
        exception_handlers={
            HTTPException: _http_error,
            MakeupVideoError: _expected_error,
            Exception: internal_error,
        },
    )
    app.router.redirect_slashes = False
    return SameOrigin(AnswerCutOff(app), host, port)


class Endpoints:
    """The functions behind the routes."""

    def __init__(self, rooms: Rooms, slow_jobs: SlowJobs) -> None:
        self._rooms, self._slow_jobs, self._uploads = rooms, slow_jobs, Uploads(slow_jobs)
        self._downloads, self._thumbnails = OneAtATime(slow_jobs.run), OneAtATime(slow_jobs.run)
        self._choices = OneAtATime(slow_jobs.run_on_device)

    async def page(self, _request: Request) -> Response:
        """Serve the page."""
        return _file("index.html")

    async def static(self, request: Request) -> Response:
        """Serve a file of the page."""
        return _file(request.path_params["name"])

    async def watch(self, socket: WebSocket) -> None:
        """Serve a page's WebSocket until it closes."""
        await socket.accept()
        try:
            room, viewer = self._rooms.enter(socket.query_params.get("session", ""))
        except UsageError as error:
            await socket.send_text(error_message(str(error)))
            await socket.close(_TRY_AGAIN_LATER)
            return
        sending = asyncio.create_task(_send(socket, viewer))
        try:
            await _listen(socket, room, viewer)
        finally:
            sending.cancel()
            self._rooms.leave(room, viewer)

    async def photo(self, request: Request) -> Response:
        """Read and paint the look in an uploaded photo. The strength of the look stays as it is."""
        room = self._room(request)
        face, name = request.query_params.get("face", ""), file_name(request)
        read = await self._uploads.run(request, lambda data: room.session.read(data, name, face))
        if isinstance(read, SeveralFaces):
            return Response(several_faces_message(name, read), 409, media_type=_JSON)
        look = replace(read.look, strength=room.session.look.strength)
        # while the photo was read, all pages may have left and returned to a new room
        room = self._rooms.find(room.session.name) or room
        room.change(look, replace(read, look=look))
        return JSONResponse({"name": name, "look": look.to_dict(), "words": read.words})

    async def photo_thumbnail(self, request: Request) -> Response:
        """Serve the photo that was read last, as a small JPEG."""
        photo = self._room(request).session.photo
        if photo is None:
            raise HTTPException(404, "no photo has been read yet")
        data = await self._downloads.run(request, photo.thumbnail)
        return Response(data, media_type="image/jpeg")

    async def portrait(self, request: Request) -> Response:
        """Paint an uploaded portrait from now on."""
        room, name = self._room(request), file_name(request)
        await self._uploads.run(request, lambda data: room.session.take_portrait(data, name))
        return JSONResponse({"name": name})

    async def portrait_thumbnail(self, request: Request) -> Response:
        """Serve the portrait without makeup, as a small JPEG."""
        session = self._room(request).session
        data = await self._downloads.run(request, session.portrait_thumbnail)
        return Response(data, media_type="image/jpeg")

    async def recording(self, request: Request) -> Response:
        """Start a recording (`on=1`) or stop it. Only the user of this machine may do this."""
        room = self._room_of_owner(request)
        on = request.query_params.get("on") == "1"
        await self._slow_jobs.run_on_device(lambda: room.session.record(on))
        return JSONResponse({"on": on})

    async def cameras(self, request: Request) -> Response:
        """List the cameras and sizes to choose from; only the user of this machine gets them."""
        session, is_owner = self._room(request).session, is_this_machine(request.scope)
        choices = await self._choices.run(request, session.cameras) if is_owner else {}
        return JSONResponse({"is_owner": is_owner, **choices})

    async def choose_camera(self, request: Request) -> Response:
        """Use another camera or size. Only the user of this machine may do this."""
        room = self._room_of_owner(request)
        name, size = (request.query_params.get(key, "") for key in ("name", "size"))
        await self._slow_jobs.run_on_device(lambda: room.session.choose_camera(name, size))
        room.announce_camera()
        choices = await self._slow_jobs.run_on_device(room.session.cameras)
        return JSONResponse({"is_owner": True, **choices})

    async def picture(self, request: Request) -> Response:
        """Serve the newest picture in full size as PNG; with `both`, before and after makeup."""
        room, both = self._room(request), "both" in request.query_params
        headers = {"content-disposition": 'attachment; filename="makeup.png"'}
        if not room.session.has_picture:
            raise HTTPException(404, "there is no picture yet")
        if request.method == "HEAD":  # painting the picture only for its length is not worth it
            head = Response(media_type="image/png", headers=headers)
            del head.headers["content-length"]
            return head
        data = await self._downloads.run(request, lambda: _png(room.session.whole_picture(both)))
        return Response(data, media_type="image/png", headers=headers)

    async def shades(self, request: Request) -> Response:
        """Read an uploaded catalogue of shades, a CSV file, and return it as JSON."""
        self._room(request)
        name = file_name(request)
        text = await self._uploads.run(
            request, lambda data: shades_message(name, data), _CATALOGUE_BYTES, "the catalogue"
        )
        return Response(text, media_type=_JSON)

    async def looks(self, _request: Request) -> Response:
        """List the ready looks with their words."""
        return Response(ready_looks_message(ready_looks()), media_type=_JSON)

    async def look_thumbnail(self, request: Request) -> Response:
        """Serve the session's portrait with the look from the request's body, as a small JPEG."""
        room = self._room(request)
        look = look_in(bytes(await read_body(request, LOOK_BYTES, "the look")))
        data = await self._thumbnails.run(request, lambda: room.session.thumbnail(look))
        return Response(data, media_type="image/jpeg")

    def _room_of_owner(self, request: Request) -> Room:
        """The room of a page on this machine. Pages on other machines may not use the camera."""
        room = self._room(request)
        if not is_this_machine(request.scope):
            raise HTTPException(403, "only a page on the machine of the camera may do this")
        return room

    def _room(self, request: Request) -> Room:
        name = request.query_params.get("session", "")
        room = self._rooms.find(name)
        if room is None and self._rooms.show.find(name) is not None:
            raise HTTPException(503, "the page is not connected now: try again in a few seconds")
        if room is None:
            raise HTTPException(404, "the session of this page has ended: reload the page")
        return room


async def _send(socket: WebSocket, viewer: Viewer) -> None:
    try:
        while (message := await viewer.next()) is not None:
            if isinstance(message, bytes):
                await socket.send_bytes(message)
            else:
                await socket.send_text(message)
        await socket.send_text(BYE)
        await socket.close(_GOING_AWAY)
    except WebSocketDisconnect:
        return  # `_listen` ends, too


async def _listen(socket: WebSocket, room: Room, viewer: Viewer) -> None:
    while (message := await socket.receive())["type"] != "websocket.disconnect":
        text = message.get("text")
        if text is None:
            viewer.queue_error("a message must be text: JSON")
        else:
            room.receive(viewer, text)


def _file(name: str) -> Response:
    """Serve a file of the page by its bare name, so that no file outside its folder is served."""
    path = next((path for path in PAGE.iterdir() if path.name == name and path.is_file()), None)
    if path is None:
        raise HTTPException(404, "there is no such file")
    return Response(
        path.read_bytes(), media_type=_KINDS.get(path.suffix, "application/octet-stream")
    )


def _png(rgb8: np.ndarray) -> bytes:
    import cv2

    _, data = cv2.imencode(".png", rgb8[..., ::-1])
    return data.tobytes()


def _error(status: int, text: str, headers: Mapping[str, str] | None = None) -> Response:
    return JSONResponse({"error": text}, status, headers=headers)


async def _http_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return _error(error.status_code, error.detail, error.headers)


async def _expected_error(_request: Request, error: Exception) -> Response:
    """Answer with the one line that the command would print for this error."""
    status = next((code for kind, code in _STATUS.items() if isinstance(error, kind)), 500)
    return _error(status, str(error))
