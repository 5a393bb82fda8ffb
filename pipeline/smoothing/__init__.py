"""Steady faces: points that do not tremble from frame to frame."""
