"""Runs a net on ONNX Runtime, with weights from the package that are checked by hash."""

import hashlib
import io
import json
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np
import onnxruntime
from makeup_video.pipeline.errors import InstallError

_SMALL_PX = 320 * 320  # of an input; after a larger one, an arena would keep much memory
SHIPPED = files("makeup_video.pipeline") / "weights"


class Net:
    """One net: crops (N, H, W, 3) uint8 R'G'B' -> its outputs by name, float32.

    options: ONNX Runtime's session options, which this changes further; None for its defaults.
    has_arena: keep memory from call to call, except the memory that a large input needed.
    Raises InstallError when the weights are missing or damaged.
    """

    def __init__(
        self,
        name: str,
        folder: Traversable = SHIPPED,
        threads: int = 1,
        options: Any = None,
        *,
        has_arena: bool = False,
    ) -> None:
        options = options or onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        # An arena keeps the most that a net ever needed, and more: 37 MB for the nets of a run.
        options.enable_cpu_mem_arena = has_arena
        # A thread that spins while it waits would take the codec's core.
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")
        self._session = onnxruntime.InferenceSession(
            read(f"{name}.onnx", folder), options, providers=["CPUExecutionProvider"]
        )
        self._outputs = [output.name for output in self._session.get_outputs()]
        self._giving_back: Any = None
        if has_arena:
            self._giving_back = onnxruntime.RunOptions()
            self._giving_back.add_run_config_entry("memory.enable_memory_arena_shrinkage", "cpu:0")

    def __call__(self, rgb8: np.ndarray) -> dict[str, np.ndarray]:
        is_large = rgb8.shape[1] * rgb8.shape[2] > _SMALL_PX
        options = self._giving_back if is_large else None
        values: list[Any] = self._session.run(self._outputs, {"rgb8": rgb8}, options)
        return dict(zip(self._outputs, values, strict=True))


def read(name: str, folder: Traversable = SHIPPED) -> bytes:
    """The bytes of a weights file, checked against its hash.

    Raises InstallError when the file is missing, or is not the one that was shipped.
    """
    try:
        data = (folder / name).read_bytes()
        wanted = json.loads((folder / "sha256.json").read_text(encoding="ascii"))[name]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise InstallError(
            f"the weights {name} are missing from {folder}: install makeup-video again"
        ) from error
    if hashlib.sha256(data).hexdigest() != wanted:
        raise InstallError(
            f"the weights {name} in {folder} are not the ones that were shipped "
            "(SHA-256 differs): install makeup-video again"
        )
    return data


def read_array(name: str, folder: Traversable = SHIPPED) -> np.ndarray:
    """The array of an .npy weights file, checked against its hash.

    Raises InstallError as `read` does.
    """
    array: np.ndarray = np.load(io.BytesIO(read(name, folder)), allow_pickle=False)
    return array
