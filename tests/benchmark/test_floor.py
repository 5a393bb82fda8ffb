"""The operation counts behind the performance floor."""

import pytest
from makeup_video.benchmark import floor
from people import clip, grey, write_video


@pytest.mark.parametrize(
    ("node", "operations"),
    [
        (("Conv", [[1, 3, 8, 8], [16, 3, 3, 3], [16]], [1, 16, 4, 4]), 2 * 27 * 16 * 16),
        (("Conv", [[2, 8, 4, 4], [8, 1, 5, 5], [8]], [2, 8, 4, 4]), 2 * 25 * 2 * 8 * 16),
        (("FusedConv", [[1, 3, 8, 8], [16, 3, 1, 1]], [1, 16, 8, 8]), 2 * 3 * 16 * 64),
        (("Gemm", [[1, 60], [60, 240], [240]], [1, 240]), 2 * 60 * 240),
        (("MatMul", [[1, 60], [60, 240]], [1, 240]), 2 * 60 * 240),
        (("Relu", [[1, 16, 4, 4]], [1, 16, 4, 4]), 0),
    ],
)
def test_operations_of_a_net_are_those_of_its_weights(node, operations):
    name, inputs, output = node
    notes = {"op_name": name, "input_type_shape": [{"float": shape} for shape in inputs],
             "output_type_shape": [{"float": output}]}  # fmt: skip
    assert floor.operations_of(notes) == operations


def test_the_nets_of_a_face_take_millions_of_operations(tmp_path):
    still = write_video(tmp_path / "a.mkv", clip(8))
    # the tracker also searches the first frame turned
    nothing = write_video(tmp_path / "b.mkv", [grey()] * 60)
    face, none = map(floor.net_operations, (still, nothing))
    assert face > none > 1e6


def test_a_larger_copy_takes_longer():
    assert 0 < floor.copy_ms(1000) < floor.copy_ms(10**9)
