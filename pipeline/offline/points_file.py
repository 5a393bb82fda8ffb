"""The sidecar with the points of every face."""

import json
from typing import Any

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.files.sidecar import Sidecar


class PointsFile(Sidecar):
    """JSON of the form {"unit": "...", "frames": [{pts, seconds, cut, faces: [...]}, ...]}, one
    frame per line."""

    what = "the points file"
    begins = '{"unit": "px of the stored picture; x, y, z", "frames": [\n'
    ends = "\n]}\n"

    def write(self, item: FrameFaces) -> None:
        """Append a frame. Raises OutputError when the file cannot be written."""
        frame = item.frame
        line = {
            "pts": frame.pts,
            "seconds": frame.seconds,
            "cut": item.cut,
            "faces": [_as_json(face) for face in item.faces],
        }
        self.append((",\n" if self.is_begun else "") + json.dumps(line))


def _as_json(face: Face) -> dict[str, Any]:
    return {
        "id": face.track_id,
        "score": round(face.score, 4),
        "mouth_visible": round(face.mouth_visible, 4),
        "points_px": np.round(face.points_px.astype(float), 2).tolist(),
    }
