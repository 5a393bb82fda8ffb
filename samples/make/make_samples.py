"""Make the sample media.

These are in.mp4 (a person who turns her head, talks and blinks), its face points in_points.npz,
portrait.jpg (a bare portrait), look.jpg (the same portrait with makeup), and the portrait of
`makeup-video demo`, a part of a frame of the clip.

    pip install -e .[samples]
    python samples/make/make_samples.py

Both pictures are public domain and come with scikit-image and matplotlib; see README.md.
"""

from __future__ import annotations

import itertools
import sys
import time
from fractions import Fraction
from pathlib import Path

import av
import cv2
import matplotlib.cbook
import numpy as np
from face import Face
from head import STEP, Head, grid, invert, load_points
from look import make_look
from motion import FPS, FRAMES, State, state
from numpy.typing import NDArray
from picture import Image, build_layers, to_canvas
from sound import RATE, voice

SAMPLES = Path(__file__).parents[1]
SIZE = (1280, 720)  # of the video, pixels
DEMO_FRAME, DEMO_BOX = 266, (400, 20, 920, 660)  # the demo's portrait; left, top, right, bottom
AIM = (224.0, 113.5)  # picture position at the middle of the frame
LUMA_NOISE, CHROMA_NOISE = 1.7, 0.8  # standard deviations in 8-bit codes
POINT_UNIT = 1 / 16  # pixels; the unit of in_points.npz
BT709 = np.float32([[0.2126, 0.7152, 0.0722], [-0.1146, -0.3854, 0.5], [0.5, -0.4542, -0.0458]])


class Studio:
    """Renders frames; holds everything that is the same in all frames."""

    def __init__(self) -> None:
        self.layers = build_layers()
        self.points = load_points()
        self.head, self.face = Head(self.points), Face(self.layers.head, self.points)
        ys, xs = np.mgrid[: SIZE[1], : SIZE[0]].astype(np.float32)
        self.xs, self.ys = xs, ys
        self.aim = to_canvas(np.array([AIM]))[0]

    def render(self, now: State) -> Image:
        """Render a frame without noise, (720, 1280, 3) float32, gamma-coded RGB 0..1."""
        forward = self.head.turn(now.pose)
        gx, gy = grid()
        hx, hy = invert(forward, gx, gy)
        x, y = self._canvas(now, 1.0)
        fx, fy = x / STEP, y / STEP
        dx, dy = (cv2.remap(d, fx, fy, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
                  for d in (hx - gx, hy - gy))  # fmt: skip
        head = cv2.remap(self.face.render(now), x + dx, y + dy, cv2.INTER_CUBIC)
        # The shoulders follow the head a little; the distant backdrop shifts less than the person.
        bx, by = np.float32(x - 0.5 * now.pose.x), np.float32(y - 0.15 * now.pose.y)
        body = cv2.remap(self.layers.body, bx, by, cv2.INTER_CUBIC)
        far = cv2.remap(self.layers.backdrop, *self._canvas(now, 0.5), cv2.INTER_LINEAR,
                        borderMode=cv2.BORDER_REPLICATE)  # fmt: skip
        out = far * (1 - body[..., 3:]) + body[..., :3]
        out = out * (1 - head[..., 3:]) + head[..., :3]
        return np.clip(out * now.gain, 0, 1)

    def place_points(self, now: State) -> NDArray[np.float32]:
        """Return the 478 face points in the frame, (478, 3), in frame pixels."""
        points = self.head.move_points(self.face.move_points(now), now.pose)
        shift_x, shift_y, zoom = now.camera
        middle = np.array([(SIZE[0] - 1) / 2 + shift_x, (SIZE[1] - 1) / 2 + shift_y, 0])
        return ((points - [*self.aim[:2], 0]) * zoom + middle).astype(np.float32)

    def _canvas(self, now: State, share: float) -> tuple[Image, Image]:
        """Return the canvas position of every frame pixel.

        share: how much of the camera's movement the layer follows, 0..1.
        """
        shift_x, shift_y, zoom = now.camera
        scale = 1 + (zoom - 1) * share
        x = (self.xs - (SIZE[0] - 1) / 2 - shift_x * share) / scale + self.aim[0]
        y = (self.ys - (SIZE[1] - 1) / 2 - shift_y * share) / scale + self.aim[1]
        return x.astype(np.float32), y.astype(np.float32)


def to_yuv(rgb: Image, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Convert RGB 0..1 to planar yuv420p bytes (1080, 1280), BT.709, limited range, with noise.

    Chroma is sited as H.264 expects: on the even columns, between two rows.
    """
    ycc = rgb @ BT709.T
    luma = 16 + 219 * ycc[..., 0]
    chroma = 128 + 224 * cv2.sepFilter2D(ycc[..., 1:], -1, np.float32([0.25, 0.5, 0.25]),
                                         np.float32([1.0]))[:, ::2]  # fmt: skip
    chroma = (chroma[::2] + chroma[1::2]) / 2
    luma = luma + LUMA_NOISE * rng.standard_normal(luma.shape, np.float32)
    chroma = chroma + CHROMA_NOISE * rng.standard_normal(chroma.shape, np.float32)
    luma, chroma = np.clip(luma, 16, 235), np.clip(chroma, 16, 240)
    planes = [luma.ravel(), chroma[..., 0].ravel(), chroma[..., 1].ravel()]
    return np.round(np.concatenate(planes)).astype(np.uint8).reshape(-1, SIZE[0])


def open_video(container: av.container.OutputContainer) -> av.VideoStream:
    """Add the H.264 stream: BT.709, limited range, the same bytes on every machine."""
    options = {
        "crf": "19",
        "preset": "slow",
        "x264-params": "keyint=60:threads=4:lookahead-threads=1",
    }
    stream = container.add_stream("libx264", rate=FPS, options=options)
    stream.width, stream.height = SIZE
    stream.pix_fmt = "yuv420p"
    stream.time_base = Fraction(1, FPS)
    context = stream.codec_context
    context.color_range, context.colorspace = 1, 1  # limited; BT.709
    context.color_primaries, context.color_trc = 1, 1  # BT.709
    return stream


def tagged_frame(planes: NDArray[np.uint8], index: int) -> av.VideoFrame:
    """Return a video frame with its colour tags."""
    frame = av.VideoFrame.from_ndarray(planes, format="yuv420p")
    frame.color_range, frame.colorspace = 1, 1
    frame.color_primaries, frame.color_trc = 1, 1
    frame.pts, frame.time_base = index, Fraction(1, FPS)
    return frame


def add_sound(container: av.container.OutputContainer, stream: av.AudioStream) -> None:
    """Encode the voice."""
    sound = voice()
    frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(sound), format="fltp", layout="stereo")
    frame.sample_rate, frame.pts, frame.time_base = RATE, 0, Fraction(1, RATE)
    for packet in (*stream.encode(frame), *stream.encode(None)):
        container.mux(packet)


def make_video(path: Path, points_path: Path) -> None:
    """Render and encode the clip, and save the face points of every frame."""
    studio, rng = Studio(), np.random.default_rng(2)
    points = np.zeros((FRAMES, 478, 2), np.int16)
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        video = open_video(container)
        audio = container.add_stream("aac", rate=RATE, layout="stereo")
        audio.bit_rate = 96000
        for index in range(FRAMES):
            now = state(index / FPS)
            planes = to_yuv(studio.render(now), rng)
            points[index] = np.round(studio.place_points(now)[:, :2] / POINT_UNIT)
            for packet in video.encode(tagged_frame(planes, index)):
                container.mux(packet)
        for packet in video.encode(None):
            container.mux(packet)
        add_sound(container, audio)
    np.savez_compressed(points_path, points=points, unit=np.float32(POINT_UNIT))


def make_portrait(path: Path) -> None:
    """Write the bare portrait: matplotlib's grace_hopper.jpg at twice its size."""
    with matplotlib.cbook.get_sample_data("grace_hopper.jpg") as file:
        data = np.frombuffer(file.read(), np.uint8)
    picture = cv2.imdecode(data, cv2.IMREAD_COLOR)
    big = cv2.resize(picture, None, fx=2, fy=2, interpolation=cv2.INTER_LANCZOS4)
    cv2.imwrite(str(path), big, [cv2.IMWRITE_JPEG_QUALITY, 92])


def make_demo_portrait(video: Path, path: Path) -> None:
    """Write the face of the clip with open eyes and closed lips: large, and without glasses."""
    with av.open(str(video)) as container:
        frames = container.decode(video=0)
        picture = next(itertools.islice(frames, DEMO_FRAME, None)).to_ndarray(format="bgr24")
    left, top, right, bottom = DEMO_BOX
    cv2.imwrite(str(path), picture[top:bottom, left:right], [cv2.IMWRITE_JPEG_QUALITY, 92])


def main() -> None:
    started = time.perf_counter()
    make_portrait(SAMPLES / "portrait.jpg")
    make_look(SAMPLES / "portrait.jpg", SAMPLES / "look.jpg")
    make_video(SAMPLES / "in.mp4", SAMPLES / "in_points.npz")
    make_demo_portrait(SAMPLES / "in.mp4", SAMPLES.parent / "web" / "page" / "portrait.jpg")
    seconds = time.perf_counter() - started
    print(
        f"in.mp4, in_points.npz, look.jpg and the portraits made in {seconds:.0f} s",
        file=sys.stderr,
    )


if __name__ == "__main__":
    main()
