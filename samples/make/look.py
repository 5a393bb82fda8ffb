"""Make look.jpg: the portrait with a look that makeup-video painted.

python samples/make/look.py
"""

from pathlib import Path

import cv2
from makeup_video.pipeline import Look, apply_look, product

SAMPLES = Path(__file__).parents[1]
LOOK = Look(
    lips=product((122, 12, 66), "satin"),
    eyes=product((24, 84, 150), "satin", "eyes"),
    zone="full",
)


def make_look(portrait: Path, path: Path) -> None:
    """Paint LOOK on the portrait and write a JPEG of quality 92, as the portrait has."""
    rgb8 = cv2.cvtColor(cv2.imread(str(portrait)), cv2.COLOR_BGR2RGB)
    painted = cv2.cvtColor(apply_look(rgb8, LOOK), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(path), painted, [cv2.IMWRITE_JPEG_QUALITY, 92])


if __name__ == "__main__":
    make_look(SAMPLES / "portrait.jpg", SAMPLES / "look.jpg")
