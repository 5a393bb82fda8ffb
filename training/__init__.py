"""How the nets are trained: not part of what runs, and the one place that imports PyTorch."""

import os

# As in makeup_video.pipeline: before ONNX Runtime is first imported, or it reports to Microsoft.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"
