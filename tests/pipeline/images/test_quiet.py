"""Libraries are quiet while a picture is read, and speak again afterwards."""

import threading
import warnings

import cv2
import pytest
from makeup_video.pipeline.images.picture_file import decode_picture
from makeup_video.pipeline.images.quiet import Quiet, silent_opencv, without_warnings
from people import portrait


def test_the_last_block_that_ends_restores_the_setting():
    calls = []
    quiet = Quiet(lambda: calls.append("begin") or (lambda: calls.append("undo")))
    first_is_in, second_is_in = threading.Event(), threading.Event()

    def first():
        with quiet:
            first_is_in.set()
            assert second_is_in.wait(20)

    thread = threading.Thread(target=first)
    thread.start()
    assert first_is_in.wait(20)
    with quiet:
        second_is_in.set()
        thread.join()
        assert calls == ["begin"]
    assert calls == ["begin", "undo"]
    with quiet, quiet:
        pass
    assert calls == ["begin", "undo"] * 2


def test_an_error_in_a_block_ends_it():
    calls = []
    quiet = Quiet(lambda: lambda: calls.append("undo"))
    with pytest.raises(KeyError), quiet:
        raise KeyError
    assert calls == ["undo"]


def test_warnings_are_ignored_in_the_block_alone():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        before = list(warnings.filters)
        with without_warnings:
            warnings.warn("a damaged block", stacklevel=1)
        assert warnings.filters == before


def test_opencv_speaks_again_after_a_picture_was_decoded(tmp_path):
    level = cv2.utils.logging.getLogLevel()
    with silent_opencv:
        assert cv2.utils.logging.getLogLevel() == cv2.utils.logging.LOG_LEVEL_SILENT != level
    decode_picture(cv2.imencode(".png", portrait())[1].tobytes(), tmp_path / "in.png")
    assert cv2.utils.logging.getLogLevel() == level
