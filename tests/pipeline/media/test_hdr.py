"""Static HDR10 metadata as the encoders spell it; whole files in test_encode.py."""

import struct

from makeup_video.pipeline.media.hdr import mastering_text


def test_mastering_text_is_what_x265_reads():
    data = struct.pack(
        "20i2i",
        34000, 50000, 16000, 50000, 13250, 50000, 34500, 50000, 7500, 50000, 3000, 50000,
        15635, 50000, 16450, 50000, 50, 10000, 10000000, 10000, 1, 1,
    )  # fmt: skip
    assert mastering_text(data, True) == (
        "G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
    )
    assert mastering_text(data, False).startswith("G(0.26500,0.69000)B(0.15000,0.06000)")
    assert mastering_text(data[:80] + struct.pack("2i", 1, 0), True) is None
