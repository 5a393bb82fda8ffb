"""The settings of a run: refused values, and settings that do not apply to pictures."""

from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import (
    Look,
    Settings,
    UsageError,
    inspect_video,
    process_looks,
    process_video,
)
from people import SAMPLES


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"faces": "me"}, "faces must be all, largest, or the number"),
        ({"faces": "-1"}, "faces must be"),
        ({"faces": "01"}, "faces must be"),
        ({"bit_depth": 9}, "bit_depth must be one of 8, 10, 12, got 9"),
        ({"start_seconds": Fraction(-1)}, "start_seconds must be at least 0"),
        ({"start_seconds": Fraction(2), "end_seconds": Fraction(2)}, "end_seconds later than it"),
        ({"start_seconds": float("nan")}, "start_seconds must be a number of seconds, got nan"),
        ({"end_seconds": "soon"}, "end_seconds must be a number of seconds, got 'soon'"),
        ({"end_seconds": "1/0"}, "end_seconds must be a number of seconds, got '1/0'"),
        ({"faces": -1}, "faces must be"),
        ({"bit_depth": "8"}, "bit_depth must be one of 8, 10, 12, got '8'"),
        ({"bit_depth": 8.0}, r"bit_depth must be one of 8, 10, 12, got 8\.0"),
        ({"start_seconds": -(10**400)}, "start_seconds must be a number of seconds, got -10000"),
        (
            {"end_seconds": 10**5000},
            "end_seconds must be a number of seconds, got something of type int",
        ),
        ({"stage_threads": 0}, r"stage_threads must be a whole number in 1\.\.128, got 0"),
        ({"decoder_threads": 3000}, "decoder_threads must be a whole number in"),
        ({"stage_threads": True}, "stage_threads must be a whole number"),
        ({"decoder_threads": -3}, r"decoder_threads must be a whole number in 0\.\.128, got -3"),
        ({"encoder_threads": "2"}, r"encoder_threads must be a whole number in 0\.\.128, got '2'"),
        ({"split_minutes": 1, "jobs": 2.5}, "jobs must be a whole number of at least 1, got 2.5"),
        ({"split_minutes": 1, "jobs": 0}, "jobs must be a whole number of at least 1, got 0"),
        ({"crf": 20.5}, "crf must be a whole number, got 20.5"),
        ({"codec": 5}, "codec must be text or None, got 5"),
        ({"on_whole": 5}, "on_whole must be a function or None, got 5"),
        ({"observe": "no"}, "observe must be a function or None, got 'no'"),
        ({"split_minutes": float("inf")}, "split_minutes must be a number of minutes, got inf"),
        ({"overwrite": "no"}, "overwrite must be True or False, got 'no'"),
        ({"overwrite": 1}, "overwrite must be True or False, got 1"),
        ({"sdr": 0.0}, "sdr must be True or False, got 0.0"),
    ],
)
def test_settings_that_do_not_fit_are_refused(values, message):
    with pytest.raises(UsageError, match=message):
        Settings(**values)


def test_settings_of_another_type_say_how_to_make_them(tmp_path):
    source, output = SAMPLES / "portrait.jpg", tmp_path / "out.png"
    for run in (
        lambda given: process_video(source, output, None, given),
        lambda given: process_looks(source, {output: Look()}, given),
        lambda given: inspect_video(source, output, None, given),
    ):
        with pytest.raises(TypeError, match=r"settings must be Settings, got dict: Settings\("):
            run({"overwrite": True})


def test_what_shows_progress_must_be_a_function(tmp_path):
    source, output = SAMPLES / "portrait.jpg", tmp_path / "out.png"
    for run in (
        lambda given: process_video(source, output, None, None, given),
        lambda given: process_looks(source, {output: Look()}, None, given),
        lambda given: inspect_video(source, output, None, None, given),
    ):
        with pytest.raises(TypeError, match="on_progress must be a function or None, got int"):
            run(5)
    assert not output.exists()


@pytest.mark.parametrize("values", [{"faces": "largest"}, {"split_minutes": 1}])
def test_a_drawing_of_faces_refuses_what_it_would_ignore(tmp_path, values):
    with pytest.raises(UsageError, match=f"in one run: leave out {next(iter(values))}"):
        inspect_video(SAMPLES / "portrait.jpg", tmp_path / "out.png", None, Settings(**values))


@given(tenths=st.integers(0, 10**6), kind=st.sampled_from([float, Decimal, str]))
def test_times_are_taken_by_their_decimals(tenths, kind):
    seconds = kind(f"{tenths // 10}.{tenths % 10}")
    assert Settings(start_seconds=seconds).start_seconds == Fraction(tenths, 10)


def test_faces_and_devices_may_be_given_as_int():
    settings = Settings(faces=0, device=1)
    assert (settings.faces, settings.device) == ("0", "1")


def test_none_means_the_default():
    names = ("faces", "device", "start_seconds", "end_seconds", "bit_depth")
    assert Settings(**dict.fromkeys(names)) == Settings()


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


@pytest.mark.parametrize(
    ("name", "usual"), [("faces", "all"), ("device", ""), ("hardware", "none")]
)
def test_none_stands_for_the_usual_choice(name, usual):
    assert getattr(Settings(**{name: None}), name) == usual


@pytest.mark.parametrize("workers", [3, [1], "ab", object()])
def test_workers_of_another_type_are_refused_at_once(workers, tmp_path):
    with pytest.raises(TypeError, match=r"workers must be a list of workers, got .*jobs"):
        process_video("missing.mp4", tmp_path / "out.mp4", workers=workers)


def test_a_share_of_memory_is_a_number(tmp_path):
    with pytest.raises(TypeError, match="memory_share must be a number"):
        process_looks("missing.mp4", {tmp_path / "out.mp4": Look()}, memory_share="0.5")
