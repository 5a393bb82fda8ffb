"""Trains and evaluates the nets.

No part of the product imports it, and it alone imports PyTorch.
"""

import os

# As in makeup_video.pipeline: set before ONNX Runtime is imported, else it reports to Microsoft.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"
