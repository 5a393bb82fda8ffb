"""The hashes of weights: the product takes what was just written, and nothing older."""

import numpy as np
import pytest
from makeup_video.pipeline import InstallError
from makeup_video.pipeline.faces.net import read_array
from makeup_video.training.list_hashes import list_hashes


def test_changed_weights_are_read_once_they_are_hashed(tmp_path, capsys):
    values = np.arange(5, dtype=np.float32)
    np.save(tmp_path / "a.npy", values)
    (tmp_path / "b.onnx").write_bytes(b"another net")
    list_hashes(tmp_path)
    assert capsys.readouterr().out == "0.00 MB in all\n"
    np.testing.assert_array_equal(read_array("a.npy", tmp_path), values)
    np.save(tmp_path / "a.npy", values + 1)
    with pytest.raises(InstallError, match="SHA-256 differs"):
        read_array("a.npy", tmp_path)
    list_hashes(tmp_path)
    np.testing.assert_array_equal(read_array("a.npy", tmp_path), values + 1)
