"""Evaluates the product's face finding on human labels, beside MediaPipe on the same pictures.

    python -m makeup_video.training.faces.evaluate --faces DIR [--weights runs/weights]

DIR/check and DIR/lipmasks_check are for evaluation alone: no net is trained on them.
Every figure starts from the whole picture, with the product's own detector.
"""

import argparse
import time
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_in
from makeup_video.pipeline.faces.lip_mask import lip_mask
from makeup_video.pipeline.faces.net import SHIPPED
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.topology import EYE_CORNERS, LIPS, LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.training.faces.contour import fill
from makeup_video.training.faces.topology68 import EYES_68, MOUTH_68, POINTS_68
from makeup_video.training.inputs import existing

CHEEKS = [50, 280, 101, 330]  # points of both cheeks that are hardly ever hidden
MUCH = 0.25  # share of a mouth's interior; mouths with more of it painted are counted
SAMPLE = Path(__file__).resolve().parents[2] / "samples" / "portrait.jpg"
NOISE_SIGMA, STILL_FRAMES = 4.0, 90  # code values; frames


def read_rgb(path: Path) -> np.ndarray:
    bgr8 = cv2.imread(str(path))
    assert bgr8 is not None, f"{path} cannot be read"
    return np.ascontiguousarray(bgr8[..., ::-1])


def nearest(nets: FaceNets, rgb8: np.ndarray, rough: np.ndarray) -> Face | None:
    """The found face that lies where a labelled face (478, >=2) is; None if there is none."""
    middle, width = rough[:, :2].mean(0), np.ptp(rough[:, 0])
    faces, _ = find_in(RgbPicture(rgb8), nets)
    gaps = [np.linalg.norm(face.points_px[:, :2].mean(0) - middle) for face in faces]
    return faces[int(np.argmin(gaps))] if gaps and min(gaps) < width / 2 else None


def errors_68(points_px: np.ndarray, human: np.ndarray) -> np.ndarray:
    """Errors (N, 68) of points (N, 478, >=2) against labels (N, 68, 2), in % of IOD."""
    off = np.linalg.norm(points_px[:, POINTS_68, :2] - human, axis=2)
    return 100 * off / np.linalg.norm(human[:, 36] - human[:, 45], axis=1)[:, None]


def report(name: str, error: np.ndarray) -> None:
    missed = np.isnan(error[:, 0])
    off = ~missed & (error.mean(1) > 10)
    print(f"{name:12} mouth {np.nanmean(error[:, MOUTH_68]):.2f}  "
          f"eyes {np.nanmean(error[:, EYES_68]):.2f}  all {np.nanmean(error):.2f}  "
          f"over 10 % or not found {100 * np.mean(off | missed):.1f} % "
          f"({off.sum()} + {missed.sum()} of {len(error)})")  # fmt: skip


def measure_points(folder: Path, nets: FaceNets) -> None:
    labels, teacher = np.load(folder / "labels.npz"), np.load(folder / "mediapipe.npz")
    found, tones = [], []
    columns = teacher["name"], teacher["points"], labels["points68"]
    for name, rough, human in zip(*columns, strict=True):
        rgb8 = read_rgb(folder / f"{Path(name).stem}.jpg")
        face = nearest(nets, rgb8, human)
        found.append(np.full((478, 3), np.nan) if face is None else face.points_px)
        tones.append(skin_tone(rgb8, rough))
    ours, human = np.stack(found), labels["points68"]
    report("MediaPipe", errors_68(teacher["points"], human))
    report("ours", errors_68(ours, human))
    for label, low, high in (("light", 41, 181), ("medium", 10, 41), ("dark", -181, 10)):
        of = (np.array(tones) >= low) & (np.array(tones) < high)
        report(f" {label}", errors_68(ours[of], human[of]))
        report("  MediaPipe", errors_68(teacher["points"][of], human[of]))


def skin_tone(rgb8: np.ndarray, points_px: np.ndarray) -> float:
    """The individual typology angle of the cheeks in degrees: over 41 light, under 10 dark."""
    at = np.rint(points_px[CHEEKS, :2]).astype(int)
    x, y = at.T.clip(4, np.array(rgb8.shape[1::-1])[:, None] - 5)
    patches = [rgb8[b - 4 : b + 5, a - 4 : a + 5].reshape(-1, 3) for a, b in zip(x, y, strict=True)]
    skin = np.median(np.concatenate(patches), 0).astype(np.float32)[None, None] / 255
    lightness, _, yellow = cv2.cvtColor(skin, cv2.COLOR_RGB2Lab)[0, 0]
    return float(np.degrees(np.arctan2(lightness - 50, yellow)))


def lip_polygon(points_px: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The mask between the lip contours, (H, W) bool."""
    mask = np.zeros(shape, np.uint8)
    for contour, value in ((LIPS_OUTER, 1), (LIPS_INNER, 0)):
        fill(mask, points_px[contour, :2], value)
    return mask > 0


def iou_of(painted: np.ndarray, lips: np.ndarray) -> float:
    """Intersection over union of two masks (H, W) bool; 0 for two empty ones."""
    return float((painted & lips).sum() / max((painted | lips).sum(), 1))


def overlap(painted: np.ndarray, human: np.ndarray) -> tuple[float, float]:
    """IoU with the lips (label 1), and the painted share of the mouth's interior (label 2)."""
    lips, interior = human == 1, human == 2
    share = painted[interior].mean() if interior.sum() > 100 else np.nan
    return iou_of(painted, lips), share


def measure_masks(folder: Path, nets: FaceNets) -> None:
    teacher = np.load(folder / "mediapipe.npz")
    theirs, ours, missed = [], [], 0
    for name, rough in zip(teacher["name"], teacher["points"], strict=True):
        stem = folder / Path(name).stem
        rgb8 = read_rgb(stem.with_suffix(".jpg"))
        human = cv2.imread(str(stem.with_suffix(".png")), cv2.IMREAD_GRAYSCALE)
        theirs.append(overlap(lip_polygon(rough, human.shape), human))
        face, painted = nearest(nets, rgb8, rough), np.zeros(human.shape, bool)
        if face is not None:
            painted = lip_mask(rgb8, face) > 0.5
        missed += face is None
        ours.append(overlap(painted, human))
    for name, scores in (("MediaPipe", theirs), ("ours", ours)):
        iou, share = np.array(scores).T
        print(f"{name:12} lip mask IoU {iou.mean():.3f}  interior painted "
              f"{100 * np.nanmean(share):.1f} %, median {100 * np.nanmedian(share):.1f} %  "
              f"(worst tenth of IoU {np.sort(iou)[: len(iou) // 10].mean():.3f})")  # fmt: skip
        much = share[share > MUCH]
        print(f"{'':12} more than {MUCH:.0%} painted: {len(much) / np.isfinite(share).sum():.0%} "
              f"of the open mouths, {much.sum() / np.nansum(share):.0%} of the mean")  # fmt: skip
    print(f"{'':12} faces not found: {missed}")


def measure_stillness(nets: FaceNets) -> None:
    """Measures the jitter of a still face at 720p under noise, and the cost of following a face."""
    portrait = cv2.resize(cv2.imread(str(SAMPLE)), (512, 600), interpolation=cv2.INTER_AREA)
    ground = np.full((720, 1280, 3), 110, np.uint8)
    ground[60:660, 384:896] = portrait
    rng, find, smooth = np.random.default_rng(0), FindFaces(nets=nets), SmoothAhead()
    raw, steady, seconds = [], [], []
    for at in range(STILL_FRAMES):
        noisy = ground + rng.normal(0, NOISE_SIGMA, ground.shape)
        frame = video_frame(np.clip(np.rint(noisy), 0, 255).astype(np.uint8), at)
        began = time.thread_time()
        item = find(frame)
        later = smooth(item)
        seconds.append(time.thread_time() - began)
        raw.append(item.faces[0].points_px)
        steady += [later.faces[0].points_px] if later is not None else []
    steady += [item.faces[0].points_px for item in smooth.drain()]
    for name, points in (("found", raw), ("smoothed", steady)):
        print(f"still face, {name}: lip points jitter by {jitter(np.stack(points)):.3f} % (rms)")
    print(f"a followed frame, 720p: median {1e3 * np.median(seconds):.2f} ms CPU, with smoothing; "
          f"mean {1e3 * np.mean(seconds[5:]):.2f}, with detection of new faces")  # fmt: skip


def video_frame(bgr8: np.ndarray, at: int) -> Frame:
    """Frame `at` of a video at 30 fps, as cameras store it: 4:2:0, BT.709, limited range."""
    picture = av.VideoFrame.from_ndarray(bgr8, format="bgr24").reformat(
        format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
    )
    return Frame(picture, at, Fraction(1, 30), ColourTags(1, 1, 1, 1))


def jitter(points_px: np.ndarray) -> float:
    """Jitter of points (T, 478, 3): rms distance of the lip points from their mean, % of IOD."""
    middle = points_px.mean(0)
    iod = np.linalg.norm(middle[EYE_CORNERS[0], :2] - middle[EYE_CORNERS[1], :2])
    off = (points_px - middle)[:, LIPS, :2]
    return 100 * float(np.sqrt((off**2).sum(-1).mean())) / iod


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faces", type=existing, required=True)
    parser.add_argument(
        "--weights", type=existing, help="folder of exported nets; default: the shipped ones"
    )
    options = parser.parse_args()
    cv2.setNumThreads(1)
    nets = FaceNets(options.weights or SHIPPED)
    measure_stillness(nets)
    measure_points(options.faces / "check", nets)
    measure_masks(options.faces / "lipmasks_check", nets)


if __name__ == "__main__":
    main()
