"""Messages name options as their reader knows them."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.cli.outcome import option_of_command
from makeup_video.pipeline.errors import (
    InputError,
    SeveralFacesError,
    StoppedError,
    UsageError,
    option,
)


@pytest.mark.parametrize("kind", [UsageError, InputError, StoppedError])
def test_python_and_the_command_each_read_their_names(kind):
    error = kind(f"{option('bit_depth')} must be 8: give {option('bit_depth', 8)}")
    assert str(error) == "bit_depth must be 8: give bit_depth=8"
    assert error.spelled(option_of_command) == "--bit-depth must be 8: give --bit-depth 8"


def test_a_text_is_quoted_in_python_and_typed_in_a_command():
    error = UsageError(f"use {option('codec', 'h264')}, {option('overwrite', True)} replaces")
    assert str(error) == "use codec='h264', overwrite=True replaces"
    assert error.spelled(option_of_command) == "use --codec h264, -y replaces"


@given(st.text())
def test_a_message_without_options_is_the_same_everywhere(text):
    error = UsageError(text.translate(dict.fromkeys(range(0xE000, 0xE003))))
    assert str(error) == error.spelled(option_of_command) == error.args[0]


def test_an_error_can_be_sent_to_another_process():
    error = pickle.loads(pickle.dumps(UsageError(f"{option('crf')} must be in 0..51")))
    assert isinstance(error, UsageError)
    assert str(error) == "crf must be in 0..51"
    assert error.spelled(option_of_command) == "--crf must be in 0..51"
    several = pickle.loads(pickle.dumps(SeveralFacesError("2 were found", ["a", "b"])))
    assert several.faces == ("a", "b")


@pytest.mark.parametrize("kind", [UsageError, InputError, StoppedError, SeveralFacesError])
def test_text_added_to_a_message_leaves_its_options_marked(kind):
    error = kind(f"leave out {option('crf')}")
    error.extend(before="in.mp4: ", after=f", or {option('face', 'largest')}")
    assert str(error) == error.args[0] == "in.mp4: leave out crf, or face='largest'"
    assert error.spelled(option_of_command) == "in.mp4: leave out --crf, or --ref-face largest"
