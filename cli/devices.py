"""`makeup-video devices`: cameras, microphones, OpenCL devices and encoders of this machine."""

import json
from collections.abc import Mapping

from makeup_video.cli.console import print_result
from makeup_video.cli.options import Debug, PrintJson
from makeup_video.cli.outcome import report_errors

EXAMPLES = ("makeup-video devices", "makeup-video devices --json")
# The title of each group, with the option that takes the names of the group.
_TITLES = {
    "cameras": "cameras (live --camera NAME)",
    "microphones": "microphones (live --audio NAME)",
    "opencl": "OpenCL devices (--device NUMBER)",
    "encoders": "encoders (--codec NAME)",
    "hardware": "hardware encoders that work (--hardware NAME)",
}


def devices(as_json: PrintJson = False, debug: Debug = False) -> None:
    """List cameras, microphones, OpenCL devices and encoders."""
    with report_errors("devices", debug=debug):
        found = devices_found()
        if as_json:
            print_result(json.dumps(found, indent=2) + "\n")
            return
        print_result("\n".join(_group(_TITLES[name], rows) for name, rows in found.items()))


def devices_found() -> dict[str, dict[str, str]]:
    """For each group, the names that its option takes, with descriptions. Raises InstallError."""
    from makeup_video.pipeline.live.sources.device import cameras_by_name
    from makeup_video.pipeline.live.sources.microphone import microphones_found
    from makeup_video.pipeline.media.encoders import encoders_found
    from makeup_video.pipeline.media.hardware import hardware_found
    from makeup_video.pipeline.render.opencl import opencl_devices

    return {
        "cameras": cameras_by_name(),
        "microphones": dict(microphones_found()),
        "opencl": {str(number): name for number, name in enumerate(opencl_devices())},
        "encoders": encoders_found(),
        "hardware": dict(hardware_found()),
    }


def _group(title: str, rows: Mapping[str, str]) -> str:
    width = max(map(len, rows), default=0)
    lines = [f"  {name:{width}}  {words}".rstrip() for name, words in rows.items()]
    return "\n".join([title, *(lines or ["  none"])]) + "\n"
