"""A page without a screen, in a process of its own: takes every picture of a live run.

    python -m makeup_video.benchmark.live_viewer WS_URL ORIGIN OUT.npy

Prints "ready" once it watches. Acknowledges each picture as a browser does; ends when the server
says goodbye.
"""

import asyncio
import json
import sys
import time
from collections.abc import AsyncIterable
from pathlib import Path

import numpy as np

# of the pts in microseconds, with which the head of a picture begins: see web/session.py
_PTS_BYTES = 8


def watch(url: str, origin: str, target: Path) -> None:
    """Write (N, 2) float64: each picture's pts in microseconds, and its arrival, monotonic seconds.

    The last row is 0 and the CPU seconds of this process.
    """
    rows = asyncio.run(_watch(url, origin))
    np.save(target, np.array([*rows, (0.0, time.process_time())]))


async def _watch(url: str, origin: str) -> list[tuple[float, float]]:
    from websockets.asyncio.client import connect
    from websockets.exceptions import ConnectionClosed
    from websockets.typing import Origin

    rows: list[tuple[float, float]] = []
    async with connect(url, origin=Origin(origin), compression=None, max_size=None) as socket:
        print("ready", flush=True)
        try:
            async for pts_us in _pictures(socket):
                rows.append((pts_us, time.monotonic()))
                await socket.send(json.dumps({"type": "shown", "pts_us": pts_us}))
        except ConnectionClosed:
            pass
    return rows


async def _pictures(messages: AsyncIterable[str | bytes]) -> AsyncIterable[int]:
    async for message in messages:
        if isinstance(message, bytes):
            yield int.from_bytes(message[:_PTS_BYTES], "little")
        elif json.loads(message)["type"] == "bye":
            return


if __name__ == "__main__":
    watch(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
