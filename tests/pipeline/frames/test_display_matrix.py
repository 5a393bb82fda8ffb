"""The turn of a video's picture equals FFmpeg's rotation; mirroring alone is no turn."""

import av
import pytest
from makeup_video.pipeline.frames.display_matrix import turn_and_mirror_of, turn_of
from media import add_video, encode_frames


@pytest.mark.parametrize("degrees", [None, 0, 90, 180, 270])
@pytest.mark.parametrize("hflip", [False, True])
@pytest.mark.parametrize("vflip", [False, True])
def test_a_mirrored_video_is_turned_as_before_it_was_mirrored(tmp_path, degrees, hflip, vflip):
    path = tmp_path / "in.mp4"
    with av.open(str(path), "w") as out:
        stream = add_video(out)
        if degrees is not None:
            stream.set_display_rotation(degrees, hflip, vflip)
        encode_frames(out, stream, range(2))
    with av.open(str(path)) as container:
        picture = next(container.decode(video=0))
    upside_down = degrees is not None and vflip  # vflip is a half turn and a mirror image
    assert turn_of(picture) == ((degrees or 0) + 180 * upside_down) % 360
    assert turn_and_mirror_of(picture)[1] == (degrees is not None and hflip != vflip)
    if not (hflip or vflip):
        assert turn_of(picture) == round(picture.rotation) % 360
