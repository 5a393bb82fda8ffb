"""Evaluates the detector on held-out faces: missed faces, false detections, errors of place.

    python -m makeup_video.training.faces.evaluate_detector --weights runs/detector.pt

--weights takes checkpoints and exported nets (.onnx).

"plain" and "turned" are unchanged pictures. The other scenes are drawn as in training, but with
other faces and another seed. A face counts as found within half an inter-ocular distance of its
place and a factor of 1.5 of its size; every other detection is false.
"""

import argparse
from collections.abc import Callable, Iterator

import cv2
import numpy as np
import torch
from makeup_video.training.faces.crops import Faces
from makeup_video.training.faces.detector_pictures import (
    FACE_CENTRE,
    NOSE_TIP,
    SCENE,
    Scenes,
    ill_exposed,
)
from makeup_video.training.faces.export import from_checkpoint
from makeup_video.training.faces.infer import from_onnx
from makeup_video.training.faces.occluders import cover
from makeup_video.training.faces.train_detector import decode, letterbox
from makeup_video.training.inputs import existing, made_by

THRESHOLDS = (0.3, 0.35, 0.45)
TURNED = 0.16  # IOD between the tip of the nose and the centre line of the face
NEAR, SIZE = 0.5, np.log(1.5)  # what counts as found: IOD, log of the ratio of IOD
Drawn = tuple[np.ndarray, np.ndarray]  # scene, faces as Scenes draws them


class Trials(Scenes):
    """Draws scenes, each with one kind of difficulty."""

    def close(self) -> Drawn:
        """One face, IOD 80 to 150 px, near the middle of the picture."""
        return self._one(self.rng.uniform(80, 150), self.rng.uniform(0.35, 0.65, 2))

    def cut(self) -> Drawn:
        """One face, IOD 50 to 130 px, centre within 8 % of a border: about half is cut off."""
        centre = self.rng.uniform(0.2, 0.8, 2)
        centre[self.rng.integers(2)] = self.rng.choice([self.rng.uniform(0.01, 0.08), 0.95])
        return self._one(self.rng.uniform(50, 130), centre)

    def covered(self) -> Drawn:
        """A hand, mask, hat, microphone or the like in front of a face of IOD 20 to 110 px."""
        scene, faces = self._one(np.exp(self.rng.uniform(3, 4.7)), self.rng.uniform(0.4, 0.6, 2))
        cover(scene, faces[0], self.rng)
        return scene, faces

    def tilted(self) -> Drawn:
        """A head rolled by 30 to 50 degrees, either way."""
        scene, faces = self._one(np.exp(self.rng.uniform(3, 4.4)), np.array([0.5, 0.5]))
        turn = self.rng.choice([-1, 1]) * self.rng.uniform(30, 50)
        middle = (SCENE - 1) / 2
        matrix = cv2.getRotationMatrix2D((middle, middle), turn, 1)
        scene = cv2.warpAffine(scene, matrix, (SCENE, SCENE), borderMode=cv2.BORDER_REFLECT)
        faces[:, :2] = faces[:, :2] @ matrix[:, :2].T + matrix[:, 2]
        faces[:, 3] -= np.radians(turn)
        return scene, faces

    def ill_lit(self) -> Drawn:
        """A face at night, in glare or fog, under a coloured lamp, or without colour."""
        scene, faces = self._one(np.exp(self.rng.uniform(3, 4.7)), self.rng.uniform(0.4, 0.6, 2))
        return ill_exposed(scene, self.rng), faces

    def crowd(self) -> Drawn:
        """Twenty faces of IOD 5 to 9 px."""
        scene, found = self._ground(SCENE, SCENE), []
        while len(found) < 20:
            placed = self._scatter(scene, found, (5, 9))
            found += [] if placed is None else [placed]
        return scene, np.array(found)

    def empty(self) -> Drawn:
        """Backgrounds: noise, scikit-image's samples, surroundings of held-out faces."""
        return self._ground(SCENE, SCENE), np.zeros((0, 4))

    def decoys(self) -> Drawn:
        """Hands, skin and heads without a face."""
        scene = self._ground(SCENE, SCENE)
        self._decoys(scene, "empty")
        return scene, np.zeros((0, 4))

    def _one(self, unit: float, centre: np.ndarray) -> Drawn:
        """One face on a random background. unit: IOD px. centre: share of the scene."""
        scene = self._ground(SCENE, SCENE)
        face = self._paste(scene, self._face(), unit, centre * SCENE, whole=True)
        return scene, face[None]


def pictures(faces: Faces, chosen: np.ndarray) -> Iterator[Drawn]:
    """The chosen faces' pictures, letterboxed but otherwise unchanged."""
    for index in np.flatnonzero(chosen):
        square, scale = letterbox(faces.pictures[index][0])
        pose = faces.poses[index].astype(float)
        place = (pose @ [*FACE_CENTRE, 1] + 0.5) / scale - 0.5
        unit = np.linalg.norm(pose[:, 0]) / scale
        yield square, np.array([[*place, unit, np.arctan2(pose[1, 0], pose[0, 0])]])


def read(poses: list[np.ndarray]) -> np.ndarray:
    """Poses (2, 3) -> (F, 4) as in Scenes: centre x, y, IOD px, turn."""
    rows = [[*(f @ [*FACE_CENTRE, 1]), np.hypot(*f[:, 0]), np.arctan2(f[1, 0], f[0, 0])]
            for f in poses]  # fmt: skip
    return np.array(rows).reshape(-1, 4)


def match(found: np.ndarray, faces: np.ndarray) -> tuple[list[list[float]], int]:
    """Errors of found faces (centre in IOD, log size, turn in degrees), and false detections."""
    errors, left = [], list(found)
    for face in faces:
        for at, one in enumerate(left):
            off = np.hypot(*(one - face)[:2]) / face[2]
            size = abs(np.log(one[2] / face[2]))
            if off < NEAR and size < SIZE:
                turn = abs((one[3] - face[3] + np.pi) % (2 * np.pi) - np.pi)
                errors.append([off, size, np.degrees(turn)])
                del left[at]
                break
    return errors, len(left)


@torch.no_grad()
def score(run: Callable[[np.ndarray], np.ndarray], drawn: list[Drawn]) -> str:
    """One line of recall and false detections per picture at each threshold, and mean errors."""
    cells = [run(scene[None])[0] for scene, _ in drawn]
    parts, count = [], sum(len(faces) for _, faces in drawn)
    for threshold in THRESHOLDS:
        errors, false = [], 0
        for out, (_, faces) in zip(cells, drawn, strict=True):
            matched, made_up = match(read(decode(out, 1.0, threshold)), faces)
            errors, false = errors + matched, false + made_up
        recall = f"{100 * len(errors) / count:6.2f} %" if count else "       -"
        parts.append(f"{recall} {false / len(drawn):6.3f}")
        if threshold == THRESHOLDS[1]:
            off = np.mean(errors, 0) if errors else np.full(3, np.nan)
    return " | ".join(parts) + f" | {off[0]:.3f} {off[1]:.3f} {off[2]:.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--weights", type=existing, nargs="+", required=True)
    parser.add_argument("--count", type=int, default=500, help="scenes of each kind")
    options = parser.parse_args()
    torch.set_num_threads(1)
    faces = Faces(options.data, True)
    trials = Trials(faces, seed=5)
    turned = np.abs(faces.points[:, NOSE_TIP, 0]) > TURNED
    groups = {"plain": list(pictures(faces, np.full(len(turned), True))),
              "turned": list(pictures(faces, turned))}  # fmt: skip
    for name in ("close", "cut", "covered", "tilted", "ill_lit", "empty", "decoys", "crowd"):
        count = options.count // 5 if name == "crowd" else options.count
        groups[name] = [getattr(trials, name)() for _ in range(count)]
    for path in options.weights:
        run = from_onnx(path) if path.suffix == ".onnx" else from_checkpoint(path)
        print(f"{path}: recall and false detections per picture at", *THRESHOLDS,
              f"| centre (IOD), log size, turn (degrees) at {THRESHOLDS[1]}")  # fmt: skip
        for name, drawn in groups.items():
            print(f"{name:8} {len(drawn):4} ", score(lambda x, run=run: run(x)[0], drawn))


if __name__ == "__main__":
    main()
