"""Trains and evaluates the nets.

The product imports nothing from here, and only this package imports PyTorch.
"""

import os

# ONNX Runtime reports to Microsoft unless this is set before its import. makeup_video.pipeline sets
# the variable, too.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"
