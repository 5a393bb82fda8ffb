"""The floor: what no program could leave out, whatever it is written in.

Decoding and encoding; moving the painted pixels through memory once; the arithmetic of their paint; and
the multiplications of the face nets, at the rates that one core of this machine reaches.
"""

import gc
import json
import time
from collections.abc import Callable
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
from makeup_video.benchmark.films import frame_of, pictures
from makeup_video.benchmark.runs import RunTimer, run_bare
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.tracker import FindFaces

# Counted in kernels/paint.cl and its headers for SDR: 160 between codes and light, 90 for the surface and
# what it mirrors, 70 for shimmer, 170 for the product. Roots and divisions count as one.
OPERATIONS_PER_PX = 490
BYTES_PER_PX = 3  # 4:2:0 in 8 bits, 1.5 read and 1.5 written
_REPEATS = 200
_CODEC_PASSES = 2
_NETS_FRAMES = 120  # 4 s: their looks at whole frames come every quarter of a second
_MATRIX = 384  # rows and columns: three of them fit into the nearer caches
_SOME_BYTES = 64 * 1024  # of a copy that memory's speed is measured with


def floor_of(clip: Path, folder: Path, painted_px: int) -> dict[str, float]:
    """CPU ms a frame of all that must be done, and what it is reckoned from.

    codec: decode_ms and encode_ms, each by one thread.  least_ms: all the rest, at the best.
    """
    decode_ms = min(_decode_ms(clip) for _ in range(_CODEC_PASSES))
    both_ms = min(
        run_bare(clip, folder / "floor.mp4", (1, 1)).cpu_ms_per_frame for _ in range(_CODEC_PASSES)
    )
    rate = operations_per_ms()
    nets = net_operations(clip)
    parts = {
        "copy_ms": copy_ms(painted_px * BYTES_PER_PX // 2),
        "paint_ms": painted_px * OPERATIONS_PER_PX / rate,
        "nets_ms": nets / rate,
    }
    return {
        "decode_ms": decode_ms,
        "encode_ms": both_ms - decode_ms,
        "painted_px": painted_px,
        "moved_bytes": painted_px * BYTES_PER_PX,
        "paint_operations": painted_px * OPERATIONS_PER_PX,
        "net_operations": nets,
        "operations_per_ms": rate,
        **parts,
        "least_ms": sum(parts.values()),
    }


def _decode_ms(clip: Path) -> float:
    clock, frames = RunTimer(), 0
    for _ in pictures(clip):
        frames += 1
    return clock.run(frames).cpu_ms_per_frame


def net_operations(clip: Path) -> float:
    """Multiplications and additions a frame of the face nets, counted where they run over a film."""
    import onnxruntime  # after the pipeline, which switches its telemetry off

    with TemporaryDirectory() as folder:

        def options() -> Any:
            """Every node of the graph as it was exported is noted, with its shapes."""
            made = original()
            made.enable_profiling, made.profile_file_prefix = True, f"{folder}/net"
            made.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
            # weights that were packed for a processor have no shape any more
            made.add_session_config_entry("session.disable_prepacking", "1")
            return made

        original = onnxruntime.SessionOptions
        with patch.object(onnxruntime, "SessionOptions", options):
            find = FindFaces(nets=FaceNets())
        frames = 0
        for picture in pictures(clip, _NETS_FRAMES):
            find(frame_of(picture))
            frames += 1
        del find
        gc.collect()  # a session writes its notes when it ends
        notes = [json.loads(path.read_text()) for path in Path(folder).iterdir()]
    done = [event["args"] for note in notes for event in note if event.get("cat") == "Node"]
    return sum(map(operations_of, done)) / frames


def operations_of(node: dict[str, Any]) -> int:
    """Multiplications and additions of a node of ONNX Runtime's notes: those of its weights."""
    inputs, (output, *_) = (_shapes(node[key]) for key in ("input_type_shape", "output_type_shape"))
    if "Conv" in node["op_name"]:
        each = prod([shape for shape in inputs if len(shape) == 4][1][1:])
    elif node["op_name"] in ("Gemm", "QGemm", "MatMul"):
        each = inputs[0][-1]
    else:
        return 0
    return 2 * each * prod(output)


def _shapes(notes: list[dict[str, list[int]]]) -> list[list[int]]:
    """Each is noted by its type alone: {"float": [1, 3, 80, 112]}."""
    return [shape for one in notes for shape in one.values()]


def operations_per_ms() -> float:
    """Multiplications and additions that one core does in a ms: those of a product of matrices."""
    left, right = np.ones((2, _MATRIX, _MATRIX), np.float32)
    out = np.empty_like(left)
    return float(2 * _MATRIX**3 / least_ms(lambda: np.matmul(left, right, out=out)))


def copy_ms(count: int) -> float:
    """CPU ms to read and write so many bytes once; a film's regions are warm in the nearer caches."""
    there, back = np.ones(_SOME_BYTES, np.uint8), np.empty(_SOME_BYTES, np.uint8)
    return count / _SOME_BYTES * least_ms(lambda: np.copyto(back, there))


def least_ms(work: Callable[[], object]) -> float:
    """CPU time of the least of many repeats."""
    times = []
    for _ in range(_REPEATS):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return 1000 * min(times)
