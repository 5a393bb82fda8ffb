"""A page without a screen, in a process of its own: takes and decodes every picture of a live run.

    python -m makeup_video.benchmark.live_viewer URL OUT.npy jpeg|h264

Prints "ready" once it watches, and acknowledges each picture as a browser does. Ends when the
server says goodbye.
"""

import asyncio
import json
import sys
import time
from collections.abc import AsyncIterable, Callable
from pathlib import Path

import av
import cv2
import numpy as np
from makeup_video.web.session import HEAD, IS_VIDEO

Decode = Callable[[bytes], object]


def watch(url: str, target: Path, kind: str) -> None:
    """Write a table (N, 4) float64: each picture's pts in microseconds, the monotonic seconds at
    which it arrived and at which it was decoded, and its size in bytes.

    The last row has the CPU seconds of this process in the second column, without its start.
    """
    rows, began = asyncio.run(_watch(url, kind))
    np.save(target, np.array([*rows, (0.0, time.process_time() - began, 0.0, 0.0)]))


async def _watch(url: str, kind: str) -> tuple[list[tuple[float, float, float, float]], float]:
    """The rows, and the CPU seconds that this process had used when it began to watch."""
    from websockets.asyncio.client import connect
    from websockets.exceptions import ConnectionClosed
    from websockets.typing import Origin

    rows: list[tuple[float, float, float, float]] = []
    decode = _h264_decoder() if kind == "h264" else _decode_jpeg
    address = url.replace("http", "ws", 1) + "/ws?session=live"
    async with connect(address, origin=Origin(url), compression=None, max_size=None) as socket:
        await socket.send(json.dumps({"type": "video", "on": kind == "h264"}))
        began = time.process_time()
        print("ready", flush=True)
        try:
            async for picture in _pictures(socket):
                arrived = time.monotonic()
                pts_us, _, flags, *_ = HEAD.unpack_from(picture)
                if (flags & IS_VIDEO) == (kind == "h264"):  # the first picture may be a JPEG
                    decode(picture[HEAD.size :])
                    rows.append((pts_us, arrived, time.monotonic(), len(picture)))
                await socket.send(json.dumps({"type": "shown", "pts_us": pts_us}))
        except ConnectionClosed:
            pass
    return rows, began


async def _pictures(messages: AsyncIterable[str | bytes]) -> AsyncIterable[bytes]:
    async for message in messages:
        if isinstance(message, bytes):
            yield message
        elif json.loads(message)["type"] == "bye":
            return


def _decode_jpeg(data: bytes) -> object:
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)


def _h264_decoder() -> Decode:
    context = av.CodecContext.create("h264", "r")
    context.thread_count = 1  # more threads would hold back pictures

    def decode(data: bytes) -> object:
        return [frame.to_ndarray(format="rgb24") for frame in context.decode(av.Packet(data))]

    return decode


if __name__ == "__main__":
    watch(sys.argv[1], Path(sys.argv[2]), sys.argv[3])
