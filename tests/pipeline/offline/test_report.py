"""The lines of a report."""

from makeup_video.pipeline.offline.report import Report


def test_damage_is_counted_in_plain_english():
    report = Report("in", "out", "h264", damaged=True, corrupt_frames=1, lost_frames=2)
    report.decode_errors, report.skipped_packets = 1, 3
    (line,) = report.warnings()
    assert line == (
        "the input is damaged: 1 frame damaged, 2 frames lost, 1 packet not decodable, "
        "3 packets of other streams left out"
    )
