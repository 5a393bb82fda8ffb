"""The lines of a report."""

import re
from pathlib import Path

from makeup_video.pipeline.offline.report import Report


def test_damage_is_counted_in_plain_english():
    report = Report("in", "out", "h264", damaged=True, corrupt_frames=1, lost_frames=2)
    report.decode_errors, report.skipped_packets = 1, 3
    (line,) = report.warnings()
    assert line == (
        "the input is damaged: 1 frame damaged, 2 frames lost, 1 packet not decodable, "
        "3 packets of other streams left out"
    )


def test_the_manual_names_keys_that_a_report_has():
    page = (Path(__file__).parents[3] / "docs" / "files.md").read_text(encoding="utf-8")
    rows = page.split("## The report")[1].split("\n## ")[0].split("|---|---|\n")[1].splitlines()
    named = {key for row in rows if row for key in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert len(named) > 20 and named <= Report("in", "out", "h264").to_dict().keys()
