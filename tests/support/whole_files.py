"""Whole files through the pipeline, unpainted."""

from fractions import Fraction

from makeup_video.pipeline import Settings, process_video
from media import decoded

HALF_TICK_MKV = Fraction(1, 2000)


def through(src, dst, **settings):
    """Run the product on src, and check that the report counts as many frames out as in."""
    report = process_video(src, dst, None, Settings(**settings))
    assert report.frames_out == report.frames_in == len(decoded(dst))
    assert not report.damaged
    # also set for videos that the encoder holds back until the end
    assert report.first_packet_unix_seconds is not None
    return report
