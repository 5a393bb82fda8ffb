"""Draw the strip at the top of the README: the reference photo, and frames before and after.

python docs/make/make_strip.py
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import av
import contact_sheet as sheet
import numpy as np
from makeup_video.pipeline import Look, look_from_photo, process_video

STRIP = "strip.jpg"
PICTURES = {STRIP: lambda: draw()}
_FRAMES = (24, 40, 110)  # of samples/in.mp4: a blink, talking, a smile
_SIZE_WH = (250, 250)
_FACE: sheet.What = ((4, 33, 263), 2.1)


def draw() -> np.ndarray:
    """Draw the strip, (H, W, 3) uint8, with the settings of the README's command."""
    photo, video = sheet.SAMPLES / "look.jpg", sheet.SAMPLES / "in.mp4"
    with tempfile.TemporaryDirectory() as folder:
        painted = Path(folder) / "out.mp4"
        process_video(video, painted, look_from_photo(photo))
        before, after = (list(_faces(path)) for path in (video, painted))
    reference = sheet.Scene(sheet.read(photo)).closeup(Look(), _FACE, _SIZE_WH)
    frames = np.vstack([np.hstack(before), np.hstack(after)])
    half = _SIZE_WH[1] // 2
    left = np.pad(reference, ((half, half), (0, 10), (0, 0)), constant_values=255)
    return np.hstack([left, frames])


def _faces(path: Path) -> Iterator[np.ndarray]:
    with av.open(str(path)) as container:
        for number, frame in enumerate(container.decode(video=0)):
            if number in _FRAMES:
                scene = sheet.Scene(frame.to_ndarray(format="rgb24"))
                yield scene.closeup(Look(), _FACE, _SIZE_WH)


if __name__ == "__main__":
    sheet.take_no_options(__doc__)
    sheet.save_all(PICTURES)
