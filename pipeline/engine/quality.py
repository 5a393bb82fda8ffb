"""How much a live run leaves out of every frame on a slow machine."""

from enum import IntEnum


class QualityLevel(IntEnum):
    """What is left out of a live frame. Each level also leaves out what the levels before it do."""

    FULL = 0
    FEWER_DETECTIONS = 1  # new faces are looked for less often
    SIMPLER_TRACKING = (
        2  # the nets read a face in every second frame, and motion carries it between
    )
    LESS_DETAIL = 3  # large regions are painted at half resolution
