"""The registry of regions. A region is a file here and one in render/regions, both of its name.

Look files, command line, page, finishes, messages, renderer, warm-up and benchmark go through it.
"""

from importlib import import_module

from makeup_video.pipeline.look.regions.info import RegionInfo

# In the order in which they are painted.
_NAMES = ("lips", "eyes")

REGIONS: dict[str, RegionInfo] = {name: import_module(f"{__name__}.{name}").INFO for name in _NAMES}
