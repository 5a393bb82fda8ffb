"""The shipped reference nets tell what their PyTorch originals told when they were exported."""

import json
from pathlib import Path

import numpy as np
import pytest
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.look.regions import REGIONS
from makeup_video.training.reference.fixed_crops import fixed_crops

EXPECTED = json.loads((Path(__file__).parent / "reference_targets.json").read_text())


@pytest.mark.parametrize("region", REGIONS)
def test_onnx_gives_the_outputs_of_pytorch(region):
    told = Net(f"reference_{region}")(fixed_crops(region))["targets"]
    assert told.shape == (16, 7) and (told >= 0).all()
    assert np.ptp(told, axis=0).min() > 0.01  # no number is stuck
    assert np.abs(told - EXPECTED[region]).max() < 5e-3
