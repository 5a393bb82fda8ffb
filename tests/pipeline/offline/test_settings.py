"""The settings of a run: refused values, and settings that do not apply to pictures."""

from fractions import Fraction

import pytest
from makeup_video.pipeline import Settings, UsageError, process_video
from people import SAMPLES


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"faces": "me"}, "faces must be all, largest, or the number"),
        ({"faces": "-1"}, "faces must be"),
        ({"bit_depth": 9}, "bit_depth must be one of 8, 10, 12, got 9"),
        ({"start_seconds": Fraction(-1)}, "start_seconds must be at least 0"),
        ({"start_seconds": Fraction(2), "end_seconds": Fraction(2)}, "end_seconds later than it"),
    ],
)
def test_settings_that_do_not_fit_are_refused(values, message):
    with pytest.raises(UsageError, match=message):
        Settings(**values)


@pytest.mark.parametrize("name", ["decoder_threads", "encoder_threads", "stage_threads"])
def test_threads_mean_nothing_to_a_picture(tmp_path, name):
    assert Settings().of_videos() == []
    settings = Settings(**{name: 1})
    assert settings.of_videos() == [name]
    with pytest.raises(UsageError, match=f"leave out {name}"):
        process_video(SAMPLES / "portrait.jpg", tmp_path / "out.png", None, settings)


@pytest.mark.parametrize("span", [(-1, None), (2, 1), (1, 1)])
def test_impossible_trims_are_refused(span):
    with pytest.raises(UsageError, match="start_seconds must be"):
        Settings(start_seconds=Fraction(span[0]), end_seconds=span[1])
