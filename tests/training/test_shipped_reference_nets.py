"""The shipped reference nets give the outputs that their PyTorch originals gave at export."""

import json
from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.reference.crops import CROPPED
from makeup_video.training.reference.fixed_crops import fixed_crops

EXPECTED = json.loads((Path(__file__).parent / "reference_targets.json").read_text())


@pytest.mark.parametrize("region", CROPPED)
def test_onnx_gives_the_outputs_of_pytorch(region):
    targets = Net(f"reference_{region}")(fixed_crops(region))["targets"]
    assert targets.shape == (16, 7) and (targets >= 0).all()
    assert np.ptp(targets, axis=0).min() > 0.01  # every number varies
    assert np.abs(targets - EXPECTED[region]).max() < 5e-3
