"""Makes a checkpoint of a shipped reference net, so that training can go on from it.

    python -m makeup_video.training.reference.from_onnx lips --shades lip_shades.csv \\
        --out runs/lips-first.pt

training/faces/from_onnx.py does the same for the nets that find faces.
"""

import os
from pathlib import Path

import cv2
import torch
from makeup_video.pipeline.faces.net import SHIPPED
from makeup_video.pipeline.reference.crops import CROPPED, NUMBERS
from makeup_video.training.faces.checkpoint import Checkpoint
from makeup_video.training.faces.from_onnx import layers, other_weights, restore_convs
from makeup_video.training.inputs import existing
from makeup_video.training.reference.model import Conv, ReferenceNet
from makeup_video.training.reference.rendered_crops import renderer
from makeup_video.training.reference.train import AVERAGE, inputs, name_of, parser_of
from torch import Tensor

WEIGHTS = Path(str(SHIPPED))
CROPS = 256  # number from which the means and variances of the normalisations are computed


def restored(path: Path, net: ReferenceNet, crops: Tensor) -> ReferenceNet:
    """The net, filled so that it computes what the file does, even in training mode.

    crops: (N, 3, H, W), as the net takes them.
    """
    net.load_state_dict(other_weights(path, net), strict=False)
    restore_convs(net, Conv, [each for each in layers(path) if each.weight.ndim == 4], crops)
    return net


def main() -> None:
    parser = parser_of(__doc__, CROPPED)
    parser.add_argument(
        "--weights", type=existing, default=WEIGHTS, help="folder of the shipped nets"
    )
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.shrink = 2  # as shipped
    os.environ["POCL_MAX_PTHREAD_COUNT"] = "1"
    cv2.setNumThreads(1)
    source = renderer(options.data, options.shades, options.region, "train", seed=7)
    crops = inputs(torch.from_numpy(next(source.batches(CROPS, mix=1))[0]))
    net = ReferenceNet(options.net, torch.ones(len(NUMBERS)), options.region, options.shrink)
    restored(options.weights / f"reference_{options.region}.onnx", net, crops)
    run = Checkpoint(options.out, net, torch.optim.AdamW(net.parameters()), AVERAGE)
    run.save((name_of(options), len(NUMBERS)))


if __name__ == "__main__":
    main()
