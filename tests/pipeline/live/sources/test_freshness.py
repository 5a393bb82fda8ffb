"""The age of a camera's picture, by its time stamp."""

import pytest
from makeup_video.pipeline.live.sources.freshness import Freshness


def test_a_stale_picture_is_known_by_its_stamp_on_any_clock():
    fresh = Freshness()
    assert fresh(1000.0, 5.0, 0.03) == 5.0
    assert fresh(1000.1, 5.1, 0.0) == pytest.approx(5.1, abs=1e-4)
    assert fresh(1000.2, 5.25, 0.0) == pytest.approx(5.2, abs=1e-4)  # the stamp gives the time
    assert fresh(1000.3, 7.1, 0.0) is None
    assert fresh(1007.0, 12.0, 0.03) == 12.0
    assert fresh(9.0, 12.1, 0.0) == 12.1  # the clock was reset
    assert fresh(None, 12.2, 0.0) == 12.2


def test_a_lasting_rise_of_a_cameras_delay_is_accepted():
    fresh = Freshness()
    fresh(0.0, 0.0, 0.03)
    got = [fresh(at - 0.3, at, 0.2) for at in (1.0, 1.2, 1.4)]
    assert got == [None, 1.2, 1.4]
