"""The floor: the time that no program could save, whatever language it is written in.

The floor consists of decoding and encoding, of moving the painted pixels through memory once, of
the arithmetic that paints them, and of the multiplications of the face nets. The rates are those
that one core of this machine reaches.
"""

import gc
import json
import time
from collections.abc import Callable
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from makeup_video.benchmark.runs import run_bare, time_run
from makeup_video.benchmark.videos import frame_of, pictures
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.tracker import FindFaces

# Counted by hand in kernels/paint.cl and its headers, for SDR: 160 to convert code values to light
# and back, 90 for the surface and its reflections, 70 for shimmer, 170 for the product. A root or a
# division counts as one operation.
OPERATIONS_PER_PX = 490
BYTES_PER_PX = 3  # 4:2:0 in 8 bits, 1.5 read and 1.5 written
_NETS = ("detector", "mesh", "lips", "eye")
_REPEATS = 200
_CODEC_PASSES = 2
_NETS_FRAMES = 120  # 4 s: the detector runs every quarter of a second
_MATRIX = 384  # rows and columns: three such matrices fit into the nearer caches
_COPY_BYTES = 64 * 1024  # size of the copy that measures the speed of memory


def floor_of(clip: Path, folder: Path, painted_px: int) -> dict[str, float]:
    """CPU ms a frame of all the work that must be done, and the counts behind these times.

    decode_ms, encode_ms: of the codec, with one thread each.  least_ms: the least time of the rest.
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
    return time_run(lambda: sum(1 for _ in pictures(clip))).cpu_ms_per_frame


def net_operations(clip: Path) -> float:
    """Multiplications and additions of the face nets per frame, counted while they run."""
    with TemporaryDirectory() as folder:
        nets = FaceNets()
        for name in _NETS:
            setattr(nets, name, Net(name, options=_profiling_options(f"{folder}/{name}")))
        find, frames = FindFaces(nets=nets), 0
        for picture in pictures(clip, _NETS_FRAMES):
            find(frame_of(picture))
            frames += 1
        del find, nets
        gc.collect()  # a session writes its profile when it ends
        profiles = [json.loads(path.read_text()) for path in Path(folder).iterdir()]
    nodes = [
        event["args"] for profile in profiles for event in profile if event.get("cat") == "Node"
    ]
    return sum(map(operations_of, nodes)) / frames


def _profiling_options(prefix: str) -> Any:
    """ONNX Runtime's options to profile every node of the graph as it was exported, with shapes."""
    import onnxruntime  # after the pipeline, which switches the telemetry of ONNX Runtime off

    options = onnxruntime.SessionOptions()
    options.enable_profiling, options.profile_file_prefix = True, prefix
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    # in the profile, weights that were packed for a processor have no shape
    options.add_session_config_entry("session.disable_prepacking", "1")
    return options


def operations_of(node: dict[str, Any]) -> int:
    """Multiplications and additions with the weights of one node of ONNX Runtime's profile."""
    inputs, (output, *_) = (_shapes(node[key]) for key in ("input_type_shape", "output_type_shape"))
    if "Conv" in node["op_name"]:
        per_value = prod([shape for shape in inputs if len(shape) == 4][1][1:])
    elif node["op_name"] in ("Gemm", "QGemm", "MatMul"):
        per_value = inputs[0][-1]
    else:
        return 0
    return 2 * per_value * prod(output)


def _shapes(tensors: list[dict[str, list[int]]]) -> list[list[int]]:
    """The shapes of tensors, each of which is noted under its type: {"float": [1, 3, 80, 112]}."""
    return [shape for tensor in tensors for shape in tensor.values()]


def operations_per_ms() -> float:
    """Multiplications and additions that one core does in a ms, measured on a matrix product."""
    left, right = np.ones((2, _MATRIX, _MATRIX), np.float32)
    out = np.empty_like(left)
    return float(2 * _MATRIX**3 / least_ms(lambda: np.matmul(left, right, out=out)))


def copy_ms(count: int) -> float:
    """CPU ms to read and write `count` bytes once, in the nearer caches, as in a run."""
    source, target = np.ones(_COPY_BYTES, np.uint8), np.empty(_COPY_BYTES, np.uint8)
    return count / _COPY_BYTES * least_ms(lambda: np.copyto(target, source))


def least_ms(work: Callable[[], object]) -> float:
    """CPU ms of the quickest of _REPEATS repeats."""
    times = []
    for _ in range(_REPEATS):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return 1000 * min(times)
