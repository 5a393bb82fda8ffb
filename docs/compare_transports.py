"""Measures ways to bring pictures to a page: the delay until drawn in headless Chromium, and the server's CPU time.

    python docs/compare_transports.py [SECONDS [WAY ...]]        the table is in live.md

Needs aiortc beside makeup-video[test], and Debian's chromium. 720p at 29 frames/s from our sample. Each picture carries its number as
bright and dark squares, which the page reads off what it has drawn, once a screen refresh (so 0 to 17 ms are the
refresh's); both clocks are the machine's. "Busy" is a page whose main thread works 100 of every 130 ms on other things.
"""

import asyncio
import json
import subprocess
import sys
import time
import urllib.request
from collections.abc import AsyncIterator
from fractions import Fraction
from itertools import chain, count, cycle, islice
from pathlib import Path
from typing import Any

import av
import numpy as np
from makeup_video.pipeline import ColourTags, Frame
from makeup_video.pipeline.images.jpeg import PreviewJpeg

PORT, SIZE_WH, CELL, BITS = 8931, (1280, 720), 32, 16
RATE = 29  # not 30: every picture meets the screen's refresh in another phase
SAMPLE = Path(__file__).resolve().parent.parent / "samples" / "in.mp4"
WAYS = (
    "websocket-jpeg",
    "websocket-jpeg-imagedecoder",
    "mjpeg-http",
    "webcodecs-h264",
    "webrtc-vp8",
    "webrtc-h264",
)
FLAGS = "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"

PAGE = """<!doctype html><body><script>
const way = "%WAY%", seen = [], W = 1280, H = 720, CELL = 32, BITS = 32;
const probe = new OffscreenCanvas(CELL * BITS, CELL).getContext("2d", {willReadFrequently: true});
let shown, last = -1;
const now = () => performance.timeOrigin + performance.now();
const add = tag => document.body.appendChild(Object.assign(document.createElement(tag), {width: W, height: H}));
function look() {
  requestAnimationFrame(look);
  try { probe.drawImage(shown, 0, 0, CELL * BITS, CELL, 0, 0, CELL * BITS, CELL); } catch { return; }
  const px = probe.getImageData(0, CELL / 2, CELL * BITS, 1).data;
  const bits = Array.from({length: BITS}, (_, bit) => px[4 * (bit * CELL + CELL / 2)] > 127);
  if (bits.slice(0, 16).some((bit, at) => bit == bits[at + 16])) return;  // the other half says the opposite
  const number = bits.slice(0, 16).reduce((sum, bit, at) => sum + bit * 2 ** at, 0);
  if (number > last) { seen.push([number, now()]); last = number; }
}
let busy = false;
setInterval(() => { if (busy) for (const end = now() + 100; now() < end;); }, 130);
async function start() {
  if (way == "mjpeg-http") { shown = add("img"); shown.src = "/mjpeg"; }
  else if (way.startsWith("webrtc")) {
    shown = add("video"); shown.muted = shown.autoplay = true;
    const peer = new RTCPeerConnection();
    peer.ontrack = event => { shown.srcObject = event.streams[0]; event.receiver.jitterBufferTarget = 0; shown.play(); };
    peer.addTransceiver("video", {direction: "recvonly"});
    await peer.setLocalDescription();
    while (peer.iceGatheringState != "complete") await new Promise(done => setTimeout(done, 20));
    const {sdp, type} = peer.localDescription;
    const answer = await fetch("/offer/" + way, {method: "POST", body: JSON.stringify({sdp, type})});
    await peer.setRemoteDescription(await answer.json());
  } else {
    shown = add("canvas"); const paint = shown.getContext("2d");
    const socket = new WebSocket("ws://" + location.host + "/ws/" + way); socket.binaryType = "arraybuffer";
    let decoder, first = true, tick = 0;
    if (way == "webcodecs-h264") {
      decoder = new VideoDecoder({error: e => console.log(e),
        output: frame => { paint.drawImage(frame, 0, 0); frame.close(); socket.send("shown"); }});
      decoder.configure({codec: "avc1.42E01F", optimizeForLatency: true});
    }
    socket.onmessage = async event => {
      if (decoder) { decoder.decode(new EncodedVideoChunk({type: first ? "key" : "delta", timestamp: tick++, data: event.data})); first = false; return; }
      const type = "image/jpeg";
      const bitmap = way == "websocket-jpeg" ? await createImageBitmap(new Blob([event.data], {type}))
        : (await new ImageDecoder({data: event.data, type}).decode()).image;
      paint.drawImage(bitmap, 0, 0); bitmap.close(); socket.send("shown");
    };
  }
  look();
}
start();
</script>"""


class Source:
    """Numbered pictures in real time: the newest wins."""

    def __init__(self) -> None:
        with av.open(str(SAMPLE)) as box:
            few = islice(box.decode(video=0), 60)
            self._pictures = [p.reformat(*SIZE_WH, format="yuv420p") for p in few]
        self.times: list[float] = []
        self.number, self.newest, self._came = -1, self._pictures[0], asyncio.Condition()

    async def run(self) -> None:
        begin = time.monotonic()
        there_and_back = cycle(chain(self._pictures, self._pictures[-2:0:-1]))
        for number, picture in zip(count(), there_and_back, strict=False):
            await asyncio.sleep(begin + number / RATE - time.monotonic())
            self.times.append(time.time())
            luma = np.frombuffer(memoryview(picture.planes[0]), np.uint8).reshape(SIZE_WH[1], -1)
            bits = number >> np.arange(BITS) & 1
            luma[:CELL, : CELL * BITS * 2] = np.where(np.append(bits, 1 - bits), 220, 30).repeat(
                CELL
            )
            self.number, self.newest = number, picture
            async with self._came:
                self._came.notify_all()

    async def next(self, after: int) -> tuple[int, av.VideoFrame]:
        async with self._came:
            await self._came.wait_for(lambda: self.number > after)
        return self.number, self.newest


def serve() -> None:
    import uvicorn
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import HTMLResponse, JSONResponse, StreamingResponse
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket, WebSocketDisconnect

    source, jpeg, peers = Source(), PreviewJpeg(), []

    def as_jpeg(picture: av.VideoFrame) -> bytes:
        frame = Frame(picture, 0, Fraction(1, RATE), ColourTags())
        return jpeg(frame.planes, frame.chroma, 8, frame.tags)

    async def page(request: Request) -> HTMLResponse:
        return HTMLResponse(PAGE.replace("%WAY%", request.path_params["way"]))

    async def figures(_: Request) -> JSONResponse:
        return JSONResponse({"cpu": time.process_time(), "times": source.times})

    async def mjpeg(_: Request) -> StreamingResponse:
        async def parts() -> AsyncIterator[bytes]:
            number = -1
            while True:
                number, picture = await source.next(number)
                data = as_jpeg(picture)
                yield b"--next\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(
                    data
                )
                yield data + b"\r\n"

        return StreamingResponse(parts(), media_type="multipart/x-mixed-replace; boundary=next")

    async def socket(ws: WebSocket) -> None:
        await ws.accept()
        as_bytes = h264() if ws.path_params["way"] == "webcodecs-h264" else as_jpeg
        number, flying = -1, asyncio.Semaphore(2)

        async def acknowledged() -> None:
            while True:
                await ws.receive_text()
                flying.release()

        listening = asyncio.ensure_future(acknowledged())
        try:
            while not listening.done():
                await flying.acquire()
                number, picture = await source.next(number)
                await ws.send_bytes(as_bytes(picture))
        except (WebSocketDisconnect, RuntimeError):
            pass
        listening.cancel()

    async def offer(request: Request) -> JSONResponse:
        from aiortc import (
            RTCPeerConnection,
            RTCRtpSender,
            RTCSessionDescription,
            VideoStreamTrack,
        )

        class Track(VideoStreamTrack):
            _number = -1

            async def recv(self) -> av.VideoFrame:
                self._number, picture = await source.next(self._number)
                copy = picture.reformat(format="yuv420p")
                copy.pts, copy.time_base = self._number * 90000 // RATE, Fraction(1, 90000)
                return copy

        peer = RTCPeerConnection()
        peers.append(peer)
        await peer.setRemoteDescription(RTCSessionDescription(**await request.json()))
        sender = peer.addTrack(Track())
        wanted = "video/" + request.path_params["way"].removeprefix("webrtc-").upper()
        codecs = RTCRtpSender.getCapabilities("video").codecs
        line = next(t for t in peer.getTransceivers() if t.sender == sender)
        line.setCodecPreferences([codec for codec in codecs if codec.mimeType == wanted])
        await peer.setLocalDescription(await peer.createAnswer())
        return JSONResponse({"sdp": peer.localDescription.sdp, "type": "answer"})

    app = Starlette(
        routes=[
            Route("/page/{way}", page),
            Route("/figures", figures),
            Route("/mjpeg", mjpeg),
            WebSocketRoute("/ws/{way}", socket),
            Route("/offer/{way}", offer, methods=["POST"]),
        ]
    )

    async def everything() -> None:
        running = asyncio.ensure_future(source.run())
        await uvicorn.Server(
            uvicorn.Config(app, port=PORT, log_level="warning", ws_per_message_deflate=False)
        ).serve()
        running.cancel()

    asyncio.run(everything())


def h264() -> Any:
    context: Any = av.CodecContext.create("libx264", "w")
    context.width, context.height = SIZE_WH
    context.pix_fmt, context.time_base, context.framerate = "yuv420p", Fraction(1, RATE), RATE
    context.options = {
        "preset": "ultrafast",
        "tune": "zerolatency",
        "crf": "23",
        "profile": "baseline",
    }
    number = count()

    def encode(picture: av.VideoFrame) -> bytes:
        picture.pts, picture.time_base, picture.pict_type = next(number), Fraction(1, RATE), 0
        return b"".join(bytes(packet) for packet in context.encode(picture))

    return encode


def figures() -> dict[str, Any]:
    with urllib.request.urlopen(f"http://127.0.0.1:{PORT}/figures") as answer:
        got: dict[str, Any] = json.load(answer)
    return got


def measure(browser: Any, way: str, seconds: float) -> None:
    page = browser.new_page(viewport={"width": SIZE_WH[0], "height": SIZE_WH[1]})
    page.goto(f"http://127.0.0.1:{PORT}/page/{way}", wait_until="domcontentloaded")
    time.sleep(3)  # the first pictures pay for the decoder's start
    cells = [way]
    for busy in (False, True):
        page.evaluate(f"busy = {json.dumps(busy)}; seen.length = 0")
        before = figures()
        time.sleep(seconds)
        seen, after = page.evaluate("seen"), figures()
        delays = [at - 1000 * after["times"][number] for number, at in seen]
        p50, p95 = np.percentile(delays, (50, 95)) if delays else (np.nan, np.nan)
        cells += [f"{p50:.0f}", f"{p95:.0f}", f"{len(seen) / seconds:.1f}"]
        frames = len(after["times"]) - len(before["times"])
        cells += [f"{1000 * (after['cpu'] - before['cpu']) / frames:.1f}"]
    print("| " + " | ".join(cells) + " |", flush=True)
    page.close()


def main(seconds: float) -> None:
    from playwright.sync_api import sync_playwright

    server = subprocess.Popen([sys.executable, __file__, "serve"])
    try:
        time.sleep(4)
        before, _ = figures(), time.sleep(2)
        after = figures()
        idle = (after["cpu"] - before["cpu"]) / (len(after["times"]) - len(before["times"]))
        print(f"CPU ms a frame while nobody looks: {1000 * idle:.1f}")
        print(
            "| way | p50 ms | p95 ms | drawn a s | server CPU ms | busy: p50 | p95 | drawn a s | CPU ms |"
        )
        with sync_playwright() as play:
            browser = play.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS.split())
            for way in sys.argv[2:] or WAYS:
                measure(browser, way, seconds)
            browser.close()
    finally:
        server.kill()  # an endless answer would keep it
        server.wait()


if __name__ == "__main__":
    if sys.argv[1:] == ["serve"]:
        serve()
    else:
        main(float(sys.argv[1]) if len(sys.argv) > 1 else 8)
