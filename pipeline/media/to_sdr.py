"""Turns HDR pictures into SDR with FFmpeg's filters and a colour table of our own."""

import tempfile
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from makeup_video.kernels.colour import BT2020, PRIMARIES, REFERENCE_WHITE
from makeup_video.pipeline.errors import OutputError
from makeup_video.pipeline.frames.colour_tags import is_full_range
from makeup_video.pipeline.media.hdr import light_levels
from makeup_video.pipeline.media.tone_map import peak_of, sdr_table

# Entries of the table along each axis. At 33 one colour in a hundred is off by 6 codes of 255, at
# 65 by 3.
_SIZE = 65
_BETWEEN = "gbrp10le"  # R'G'B' in finer steps than the 8 bits of the result
_STATIC = ("MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL")


class ToSdr:
    """Turns pictures into SDR: BT.709, limited range.

    The transfer curve is sRGB's, while the tag says bt709, as in most video: players show both in
    the same way.
    picture: the first one, PQ or HLG; its colours and its peak hold for all.
    pix_fmt: of the result.  peak_nits: the brightest light of the video, in cd/m2.
    Times, field order and rotation stay. HDR10's static metadata is dropped, since it no longer
    holds.
    Raises OutputError when there is no room for a temporary file.
    """

    def __init__(self, picture: av.VideoFrame, pix_fmt: str) -> None:
        peak = peak_of(*light_levels(picture))
        self.peak_nits = peak * REFERENCE_WHITE
        primaries = int(picture.color_primaries)
        table = sdr_table(
            _SIZE,
            int(picture.color_trc),
            primaries if primaries in PRIMARIES else BT2020,
            peak,
        )
        self._tick = picture.time_base or Fraction(1, 1000)
        with ExitStack() as stack:  # the graph has read the table once it is configured
            self._graph = self._chain(picture, pix_fmt, _written(table, stack))

    def __call__(self, picture: av.VideoFrame) -> av.VideoFrame:
        picture.time_base = picture.time_base or self._tick
        self._graph.vpush(picture)
        out: av.VideoFrame = self._graph.vpull()
        out.pts, out.time_base = picture.pts, picture.time_base
        return out

    def _chain(self, picture: av.VideoFrame, pix_fmt: str, table: str) -> av.filter.Graph:
        full = is_full_range(picture.color_range, picture.format.name)
        span, matrix = ("pc" if full else "tv"), int(picture.colorspace)
        graph = av.filter.Graph()
        nodes = [
            graph.add(
                "buffer",
                f"video_size={picture.width}x{picture.height}:pix_fmt={picture.format.name}"
                f":time_base={self._tick}:colorspace={matrix}:range={span}",
            ),
            # without a tag the matrix is BT.2020's, as always with PQ and HLG
            graph.add("scale", f"in_color_matrix={'auto' if matrix != 2 else 'bt2020'}"),
            graph.add("format", f"pix_fmts={_BETWEEN}"),
            graph.add("lut3d", file=table, interp="tetrahedral"),  # a path may have a colon
            graph.add("scale", "out_color_matrix=bt709:out_range=tv"),
            graph.add("format", f"pix_fmts={pix_fmt}"),
            graph.add(
                "setparams", "color_trc=bt709:color_primaries=bt709:colorspace=bt709:range=tv"
            ),
            *(graph.add("sidedata", f"mode=delete:type={kind}") for kind in _STATIC),
            graph.add("buffersink"),
        ]
        graph.link_nodes(*nodes).configure()
        return graph


def _written(table: np.ndarray, stack: ExitStack) -> str:
    """Write a .cube file (Adobe's Cube LUT specification 1.0) to a folder for temporary files.

    stack: closing it removes the folder, even when the disk was full.
    """
    lines = (f"{red:.5f} {green:.5f} {blue:.5f}\n" for red, green, blue in table.tolist())
    try:
        path = Path(stack.enter_context(tempfile.TemporaryDirectory()), "table.cube")
        with path.open("w") as file:
            file.write(f"LUT_3D_SIZE {_SIZE}\n")
            file.writelines(lines)
    except OSError as error:
        raise OutputError(
            f"{tempfile.gettempdir()} takes no temporary file ({error.strerror}), which the "
            "conversion to SDR needs: free 10 MB there"
        ) from error
    return str(path)
