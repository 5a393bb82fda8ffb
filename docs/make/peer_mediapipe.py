"""Measure the peer: what a skilled user would write with MediaPipe's Face Mesh and OpenCV.

The peer paints lips and eyeshadow on BGR frames in one loop and encodes as `makeup-video bench`
does. It runs in turn with the bare codec loop and the product, on the same video:

    python3.11 -m venv peer && peer/bin/pip install mediapipe==0.10.21 av
    peer/bin/python docs/make/peer_mediapipe.py --product .venv/bin/makeup-video [CLIP]

MediaPipe 0.10.21 is the last version that contains these models. It needs Python 3.12 or older, and
other versions of numpy and OpenCV than makeup-video, so it has an environment of its own. The clock
starts after MediaPipe's models are loaded, but before the product's are.

Two loops are measured. "whole frames" blends as tutorials do; "face boxes" blends only around lips
and lids. Neither is slow on purpose: FaceMesh follows one face, its detector runs only when the
face is lost, and everything except the weights is uint8 in OpenCV's own code. The colour goes into
a and b of Lab, so lightness stays.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path
from statistics import median

import av
import cv2
import mediapipe as mp
import numpy as np

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
CODEC, OPTIONS = "libx264", {"preset": "veryfast", "crf": "20"}
THREADS = ((0, 0), (1, 2), (2, 3), (2, 4))  # of decoder and encoder; 0 is FFmpeg's own choice
STRENGTH = 0.6
LIP_BGR, LID_BGR = (70, 30, 150), (150, 80, 60)
LIPS_OUTER = [
    61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291, 409, 270, 269, 267, 0, 37, 39, 40, 185,
]  # fmt: skip
LIPS_INNER = [
    78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308, 415, 310, 311, 312, 13, 82, 81, 80, 191,
]  # fmt: skip
# Along the edge of the upper lid and back below the brow.
LIDS = (
    [33, 246, 161, 160, 159, 158, 157, 173, 133, 243, 190, 56, 28, 27, 29, 30, 247, 130],
    [263, 466, 388, 387, 386, 385, 384, 398, 362, 463, 414, 286, 258, 257, 259, 260, 467, 359],
)
# Runs in the product's environment. Arguments: clip, video to write, height, frames.
MAKE_VIDEO = (
    "import sys; from pathlib import Path; from makeup_video.benchmark.videos import make_video; "
    "clip, video, height, frames = sys.argv[1:]; "
    "print(make_video(Path(clip), Path(video), int(height), int(frames)).description)"
)


class Peer:
    """Paints decoded pictures. `painted` counts the pictures with a face."""

    def __init__(self, whole: bool) -> None:
        self.whole, self.painted = whole, 0
        self.mesh = mp.solutions.face_mesh.FaceMesh(max_num_faces=1, refine_landmarks=True)

    def __call__(self, picture: av.VideoFrame) -> av.VideoFrame:
        bgr8 = picture.to_ndarray(format="bgr24")
        rgb8 = cv2.cvtColor(bgr8, cv2.COLOR_BGR2RGB)
        rgb8.flags.writeable = False  # spares MediaPipe a copy
        found = self.mesh.process(rgb8).multi_face_landmarks
        if not found:
            return picture
        self.painted += 1
        size = np.array(bgr8.shape[1::-1])
        points = np.array([(point.x, point.y) for point in found[0].landmark]) * size
        points = np.rint(points).astype(np.int32)
        self.paint(bgr8, [points[LIPS_OUTER]], [points[LIPS_INNER]], LIP_BGR)
        self.paint(bgr8, [points[lid] for lid in LIDS], [], LID_BGR)
        out = av.VideoFrame.from_ndarray(bgr8, format="bgr24").reformat(format="yuv420p")
        out.pts, out.time_base = picture.pts, picture.time_base
        return out

    def paint(self, bgr8, add, leave_out, colour) -> None:
        """Paint inside the rings `add` and outside the rings `leave_out`, in place."""
        x, y, width, height = cv2.boundingRect(np.concatenate(add))
        blur = max(3, width // 16 | 1)
        x0, y0 = max(x - blur, 0), max(y - blur, 0)
        x1, y1 = x + width + blur, y + height + blur
        if self.whole:
            x0, y0, y1, x1 = 0, 0, *bgr8.shape[:2]
        part = bgr8[y0:y1, x0:x1]
        if not part.size:
            return
        mask = np.zeros(part.shape[:2], np.uint8)
        cv2.fillPoly(mask, add, 255, offset=(-x0, -y0))
        cv2.fillPoly(mask, leave_out, 0, offset=(-x0, -y0))
        mask = cv2.GaussianBlur(mask, (blur, blur), 0)
        lab = cv2.cvtColor(part, cv2.COLOR_BGR2LAB)
        _, a, b = cv2.cvtColor(np.uint8([[colour]]), cv2.COLOR_BGR2LAB)[0, 0]
        light = cv2.extractChannel(lab, 0)
        tinted = cv2.merge([light, np.full_like(light, a), np.full_like(light, b)])
        weight = mask.astype(np.float32) * (STRENGTH / 255)
        part[:] = cv2.cvtColor(cv2.blendLinear(tinted, lab, weight, 1 - weight), cv2.COLOR_LAB2BGR)


def loop(source: Path, target: Path, threads: tuple[int, int], change=None) -> dict[str, float]:
    """Decode, apply `change` to each picture, encode. Return frames/s and CPU ms a frame."""
    began, cpu, frames = time.perf_counter(), time.process_time(), 0
    with av.open(str(source)) as box, av.open(str(target), "w") as out:
        video = box.streams.video[0]
        video.thread_type, video.thread_count = "AUTO", threads[0]
        stream = out.add_stream(CODEC, rate=video.average_rate, options=OPTIONS)
        stream.width, stream.height, stream.pix_fmt = video.width, video.height, "yuv420p"
        stream.codec_context.time_base = video.time_base
        stream.codec_context.thread_count, stream.codec_context.thread_type = threads[1], "AUTO"
        for picture in box.decode(video):
            if change:
                picture = change(picture)
            picture.pict_type = 0
            out.mux(stream.encode(picture))
            frames += 1
        out.mux(stream.encode(None))
    seconds, cpu_seconds = time.perf_counter() - began, time.process_time() - cpu
    return {"fps": frames / seconds, "cpu_ms": 1000 * cpu_seconds / frames, "frames": frames}


def ours(product: Path, video: Path, target: Path, ref: Path) -> dict[str, float]:
    """Run the real command. Its report times the same span as the loops, from opening the video."""
    report = target.with_suffix(".json")
    command = [product, video, "--ref", ref, "-o", target, "--report", report, "-q", "-y"]
    command += ["--codec", "h264", "--preset", OPTIONS["preset"], "--crf", OPTIONS["crf"]]
    subprocess.run([str(word) for word in command], check=True)
    done = json.loads(report.read_text())
    check(done["painted_frames"], done["frames_out"], "makeup-video")
    frames = done["frames_out"]
    return {"fps": done["fps"], "cpu_ms": 1000 * done["cpu_seconds"] / frames, "frames": frames}


def check(painted: int, frames: int, who: str) -> None:
    if painted < 0.95 * frames:
        raise SystemExit(f"{who} painted {painted} of {frames} frames: use a clip with a face")


def peer(video: Path, target: Path, threads: tuple[int, int], whole: bool) -> dict[str, float]:
    """Run the peer. The clock starts after its models are loaded."""
    change = Peer(whole)
    done = loop(video, target, threads, change)
    check(change.painted, done["frames"], "the peer")
    return done


def compare(options: argparse.Namespace, video: Path, folder: Path) -> dict[str, dict[str, float]]:
    """Run all in turn and return their medians. Each round begins with another one.

    The loops use their fastest thread settings.
    """
    target = folder / "out.mp4"
    loop(video, target, THREADS[0])  # warms the file cache; not counted
    best = max(THREADS, key=lambda threads: loop(video, target, threads)["fps"])
    best_peer = max(THREADS, key=lambda threads: peer(video, target, threads, False)["fps"])
    work = {
        "bare": lambda: loop(video, target, best),
        "peer, whole frames": lambda: peer(video, target, best_peer, True),
        "peer, face boxes": lambda: peer(video, target, best_peer, False),
        "makeup-video": lambda: ours(options.product, video, target, options.ref),
    }
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in work}
    names = list(work)
    for number in range(options.rounds):
        first = number % len(names)
        for name in names[first:] + names[:first]:
            runs[name].append(work[name]())
    return {
        name: {key: median(run[key] for run in done) for key in ("fps", "cpu_ms")}
        for name, done in runs.items()
    }


def print_table(height: str, video: str, rows: dict[str, dict[str, float]]) -> None:
    print(
        f"\n{height}: {video}\n\n| | frames/s | ratio to bare | CPU ms a frame | makeup-video is |"
    )
    print("|---|---|---|---|---|")
    bare, best = rows["bare"]["fps"], rows["makeup-video"]["fps"]
    for name, row in rows.items():
        times = f"{best / row['fps']:.2f} times as fast" if name.startswith("peer") else ""
        cells = (f"{row['fps']:.1f}", f"{row['fps'] / bare:.3f}", f"{row['cpu_ms']:.2f}", times)
        print(f"| {name} | {' | '.join(cells)} |")


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clip", type=Path, nargs="?", default=SAMPLES / "in.mp4")
    parser.add_argument(
        "--product",
        type=Path,
        required=True,
        help="the command makeup-video, with its Python in the same folder",
    )
    parser.add_argument(
        "--ref",
        type=Path,
        default=SAMPLES / "look.jpg",
        help="photo with the look that makeup-video paints",
    )
    parser.add_argument(
        "--sizes", default="720p,1080p", help="heights of the video; the face fills half of each"
    )
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--picture", type=Path, help="also save a frame that the peer painted")
    return parser.parse_args()


def main() -> None:
    options = parse_arguments()
    with tempfile.TemporaryDirectory() as name:
        video = Path(name) / "video.mp4"
        for size in options.sizes.split(","):
            height, frames = size.removesuffix("p"), str(round(options.seconds * 30))
            command = [options.product.with_name("python"), "-c", MAKE_VIDEO, options.clip, video]
            words = [str(word) for word in (*command, height, frames)]
            description = subprocess.run(
                words, check=True, stdout=subprocess.PIPE, text=True
            ).stdout
            print_table(size, description.strip(), compare(options, video, Path(name)))
        if options.picture:
            with av.open(str(video)) as box:
                Peer(whole=True)(next(box.decode(video=0))).to_image().save(options.picture)


if __name__ == "__main__":
    main()
