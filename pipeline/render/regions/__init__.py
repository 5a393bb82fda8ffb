"""Where each region of makeup lies on a face: one file a region, of the same name as in
look/regions.

Such a file has an object REGION that follows the protocol of base.py.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from makeup_video.pipeline.look.regions import REGIONS

if TYPE_CHECKING:
    from makeup_video.pipeline.render.regions.base import Region

# In the order in which they are painted.
PAINTED: "dict[str, Region]" = {
    name: import_module(f"{__name__}.{name}").REGION for name in REGIONS
}
