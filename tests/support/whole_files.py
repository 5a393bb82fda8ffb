"""Whole files through the pipeline, unpainted."""

from fractions import Fraction

from makeup_video.pipeline import Settings, process_video
from media import decoded

HALF_TICK_MKV = Fraction(1, 2000)


def through(src, dst, **settings):
    """Run the product on src; the report says frames out = frames in."""
    report = process_video(src, dst, None, Settings(**settings))
    assert report.frames_out == report.frames_in == len(decoded(dst))
    assert not report.damaged
    assert (
        report.first_packet_unix_seconds is not None
    )  # also of films that the encoder keeps whole
    return report
