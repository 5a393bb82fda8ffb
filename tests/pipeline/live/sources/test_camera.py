"""The source of a live run: its settings, and the file or camera that a name opens."""

import pytest
from makeup_video.pipeline import InputError, UsageError
from makeup_video.pipeline.live.sources import device
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from PIL import Image


def test_a_name_too_long_for_any_file_is_refused_in_one_line():
    with pytest.raises(InputError, match="cannot be read: File name too long; give a file"):
        open_source(CameraSettings(name="x" * 5000), pytest.fail)


# -- settings and names
# ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "wrong", [{"size": "720p"}, {"size": "0x5"}, {"rate": 0}, {"pixels": "h264"}, {"name": ""}]
)
def test_invalid_settings_are_refused_in_one_line(wrong):
    with pytest.raises(UsageError) as caught:
        CameraSettings(**wrong)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith((*wrong, "the name of the camera"))


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("http://host/x.mp4", "^http://host/x.mp4 is an address"),
        ("rtsp://host/x", "^rtsp://host/x is an address"),
        ("concat:a|b", "does not exist"),
        ("missing.mp4", "does not exist"),
    ],
)
def test_only_files_of_this_machine_are_played(name, why):
    with pytest.raises(InputError, match=why):
        open_source(CameraSettings(name=name), pytest.fail)


def test_without_a_camera_the_error_offers_to_play_a_video(monkeypatch):
    monkeypatch.setattr(device, "cameras_found", list)
    with pytest.raises(
        InputError, match=r"^no camera was found on this machine: plug one in, or"
    ) as caught:
        open_source(CameraSettings(), pytest.fail)
    assert "or play a video with camera='FILE'" in str(caught.value)
    monkeypatch.setattr(device, "cameras_found", lambda: ["/dev/video99"])
    with pytest.raises(
        InputError, match=r"no camera can be opened \(.*found: /dev/video99\): name"
    ):
        open_source(CameraSettings(), pytest.fail)


def test_a_picture_is_no_camera(tmp_path):
    path = tmp_path / "photo.png"
    Image.new("RGB", (8, 8)).save(path)
    with pytest.raises(InputError, match="is a picture, and a camera needs a video: give one"):
        open_source(CameraSettings(name=str(path)), pytest.fail)
