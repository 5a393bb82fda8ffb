"""How much a live run leaves out of every frame on a slow machine."""

from enum import IntEnum


class QualityLevel(IntEnum):
    """What is left out of a live frame. Each level also leaves out what the levels before it do."""

    FULL = 0
    # new faces are looked for less often
    FEWER_DETECTIONS = 1
    # the nets read a face in every second frame, and its motion is measured in between
    SIMPLER_TRACKING = 2
    # large regions are painted at half resolution
    LESS_DETAIL = 3
