"""The videos that `makeup-video bench` measures with, all made from one clip.

A video may be longer than its clip. The clip is then played forwards, backwards, forwards ...
without a jump. A jump would be a scene cut, after which the detector looks for every face anew.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, islice, repeat
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import av
import numpy as np
from makeup_video.pipeline import ColourTags, Frame, InputError
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.media.input_file import open_video

CODEC, PRESET, CRF = "libx264", "veryfast", 20
RATE = 30  # frames/s of every video here
FACE_SHARE = 0.5  # face, from the top of the forehead to the chin, by the height of a video
X264_OPTIONS = {"preset": PRESET, "crf": str(CRF)}
_NEARLY_LOSSLESS = {"preset": "ultrafast", "crf": "12"}  # for intermediate files
_GROUP = 15  # frames from one keyframe to the next, in a video that is also read backwards
_PROBE = 30  # faces are counted in every 30th frame
_FOREHEAD, _CHIN = 10, 152  # landmarks
_GREY = 110

# x0, y0, x1, y1 in px; outside the picture, its border pixels are repeated
Rectangle = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class Video:
    """A video to measure with.

    faces: how many faces it shows.  is_cropped: whether it was cropped so that its one face fills
    FACE_SHARE of the height.
    """

    path: Path
    size_wh: tuple[int, int]
    frames: int
    faces: int
    is_cropped: bool

    @property
    def description(self) -> str:
        """Size, length and faces in words."""
        shown = f"{self.faces} face{'' if self.faces == 1 else 's'}"
        if self.is_cropped:
            shown = f"one face scaled to {FACE_SHARE:g} of the height"
        return f"{self.size_wh[0]}x{self.size_wh[1]}, {self.frames} frames, {shown}"


def make_video(
    source: Path,
    target: Path,
    height_px: int,
    frames: int,
    *,
    as_is: bool = False,
    width_px: int | None = None,
    loops: bool = False,
) -> Video:
    """Scale a clip to a height, as H.264 at 30 frames/s without sound.

    A clip of one face is cropped to 16:9 (or to width_px) so that the face fills FACE_SHARE of the
    height. A clip of several faces is only scaled, as is every clip with as_is.
    frames: length of the video.  loops: the end of the video leads back to its beginning; the video
    may then be shorter.  Raises InputError for a clip that shows no face or is damaged.
    """
    faces, size_wh, box = _view(source, frames)
    is_cropped = faces == 1 and not as_is
    if is_cropped:
        width_px = width_px or round(height_px * 8 / 9) * 2
        box = _around(box, width_px / height_px, size_wh)
    else:
        box = (0, 0, *size_wh)
        width_px = max(round(size_wh[0] * height_px / size_wh[1] / 2), 1) * 2
    most = frames // 2 + 1 if loops else frames
    with TemporaryDirectory(dir=target.parent) as folder:
        forwards = Path(folder) / "forwards.mkv"
        pictures = islice(_upright(source), most)
        scaled = (_scaled(planes, box, (width_px, height_px)) for planes in pictures)
        unique = write_video(forwards, scaled, {**_NEARLY_LOSSLESS, "g": str(_GROUP)})
        if loops:
            frames = max(2 * (unique - 1), 1)
        write_video(target, islice(_there_and_back(forwards, unique), frames), X264_OPTIONS)
    return Video(target, (width_px, height_px), frames, faces, is_cropped)


def _view(source: Path, frames: int) -> tuple[int, tuple[int, int], Rectangle]:
    """The number of faces in a clip, the clip's size, and its face as a rectangle of no width.

    The rectangle is a line down the middle of the face, from the forehead to the chin, at the
    average place. Raises InputError for a clip that has no frame, is damaged or shows no face.
    """
    counts, ends, size_wh = [], [], (0, 0)
    for planes in islice(_upright(source), 0, frames, _PROBE):
        size_wh = planes.shape[2], planes.shape[1]
        faces = find_faces_in_frame(frame_of(av.VideoFrame.from_ndarray(planes, "yuv444p")))[0]
        counts.append(len(faces.faces))
        if faces.faces:
            ends.append(faces.faces[0].points_px[[_FOREHEAD, _CHIN], :2])
    if not counts:
        raise InputError(f"{source} has no frame to measure with: give a clip that plays")
    if 2 * len(ends) <= len(counts):
        raise InputError(
            f"{source} shows no face to paint on in {len(counts) - len(ends)} of the {len(counts)} "
            "frames looked at: give a clip of somebody who looks at the camera"
        )
    height = np.mean([np.linalg.norm(top - chin) for top, chin in ends])
    x, y = np.mean(ends, axis=(0, 1))
    box = (round(x), round(y - height / 2), round(x), round(y + height / 2))
    return max(1, round(median(counts))), size_wh, box


def _around(face: Rectangle, aspect: float, size_wh: tuple[int, int]) -> Rectangle:
    """A box of this aspect (width / height) in which the face fills FACE_SHARE of the height.

    The face is in the middle of the box, or only as far off as the picture's borders require.
    """
    x, y0, _, y1 = face
    height = round((y1 - y0) / FACE_SHARE)
    width = round(height * aspect)
    left, top = x - width // 2, (y0 + y1 - height) // 2
    if width <= size_wh[0]:
        left = min(max(left, 0), size_wh[0] - width)
    if height <= size_wh[1]:
        top = min(max(top, 0), size_wh[1] - height)
    return left, top, left + width, top + height


def _upright(source: Path) -> Iterator[np.ndarray]:
    """The pictures of any video, upright: (3, H, W) uint8, Y'CbCr 4:4:4. Raises InputError."""
    opened = open_video(local_file(source))
    try:
        for picture in opened.container.decode(opened.video):
            planes = picture.reformat(format="yuv444p").to_ndarray()
            yield np.rot90(planes, round(picture.rotation / 90), axes=(1, 2))
    except av.FFmpegError as error:
        raise InputError(
            f"{source} is damaged: {error.strerror}. Give an undamaged video to measure with"
        ) from error
    finally:
        opened.close()


def _scaled(planes: np.ndarray, box: Rectangle, size_wh: tuple[int, int]) -> av.VideoFrame:
    """The part of planes (3, H, W) inside a box, scaled to a size, as 4:2:0."""
    x0, y0, x1, y1 = box
    height, width = planes.shape[1:]
    inside = planes[:, max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)]
    beyond = (
        (0, 0),
        (max(-y0, 0), max(y1 - height, 0)),
        (max(-x0, 0), max(x1 - width, 0)),
    )
    cropped = np.ascontiguousarray(np.pad(inside, beyond, mode="edge"))
    picture = av.VideoFrame.from_ndarray(cropped, format="yuv444p")
    return picture.reformat(*size_wh, format="yuv420p")


def _there_and_back(source: Path, unique: int) -> Iterator[av.VideoFrame]:
    """The pictures 0 1 ... n-1 n-2 ... 1 0 1 ... without end; a keyframe every _GROUP pictures."""
    return chain.from_iterable(
        chain(pictures(source), _backwards(source, unique)) for _ in repeat(None)
    )


def _backwards(source: Path, unique: int) -> Iterator[av.VideoFrame]:
    """The pictures n-2 ... 1, with only one group of _GROUP pictures in memory at a time."""
    with av.open(str(source)) as box:
        video = box.streams.video[0]
        assert video.time_base is not None
        for first in range((unique - 1) // _GROUP * _GROUP, -1, -_GROUP):
            box.seek(round(Fraction(first, RATE) / video.time_base), stream=video)
            group = {}
            for picture in box.decode(video):
                assert picture.pts is not None
                number = round(picture.pts * video.time_base * RATE)
                if number >= first + _GROUP:
                    break
                group[number] = picture
            for number in reversed(range(max(first, 1), min(first + _GROUP, unique - 1))):
                yield group[number]


def pictures(source: Path, count: int | None = None) -> Iterator[av.VideoFrame]:
    """Decode pictures with a single thread, so that nothing else runs while painting is timed."""
    with av.open(str(source)) as box:
        video = box.streams.video[0]
        video.thread_type, video.codec_context.thread_count = "NONE", 1
        yield from islice(box.decode(video), count)


def frame_of(picture: av.VideoFrame) -> Frame:
    """A picture as the product sees it."""
    base = picture.time_base or Fraction(1, RATE)
    return Frame(picture, picture.pts or 0, base, ColourTags.of(picture))


def write_video(target: Path, content: Iterable[av.VideoFrame], options: dict[str, str]) -> int:
    """Write pictures in 4:2:0, one every 1/30 s; returns their number."""
    index = -1
    with av.open(str(target), "w") as out:
        stream: Any = None
        for index, picture in enumerate(content):
            if stream is None:
                stream = out.add_stream(CODEC, rate=RATE, options=options)
                stream.width, stream.height = picture.width, picture.height
                stream.pix_fmt = "yuv420p"
            picture.pts, picture.time_base, picture.pict_type = index, Fraction(1, RATE), 0
            out.mux(stream.encode(picture))
        if stream is not None:
            out.mux(stream.encode(None))
    return index + 1


def first_frames(source: Path, target: Path, count: int) -> None:
    """Write only the first `count` pictures of a video."""
    write_video(target, pictures(source, count), X264_OPTIONS)


def repeat_video(source: Path, target: Path, times: int) -> Path:
    """Repeat a video that was made with `loops`; its packets are copied, not encoded again."""
    with av.open(str(source)) as box, av.open(str(target), "w") as out:
        video = box.streams.video[0]
        stream = out.add_stream_from_template(video)
        packets = [packet for packet in box.demux(video) if packet.size]
        length = sum(packet.duration or 0 for packet in packets)
        for again in range(times):
            for packet in packets:
                copy = av.Packet(bytes(packet))
                assert packet.pts is not None and packet.dts is not None
                copy.pts, copy.dts = packet.pts + again * length, packet.dts + again * length
                copy.time_base, copy.duration = packet.time_base, packet.duration
                copy.is_keyframe, copy.stream = packet.is_keyframe, stream
                out.mux(copy)
    return target


def tile(source: Path, target: Path, faces: int, grid: tuple[int, int]) -> Path:
    """Show a video in the first `faces` tiles of a (columns, rows) grid; the rest is grey."""
    columns, rows = grid

    def tiled(picture: av.VideoFrame) -> av.VideoFrame:
        planes = picture.reformat(format="yuv444p").to_ndarray()
        _, height, width = planes.shape
        whole = np.empty((3, rows * height, columns * width), np.uint8)
        whole[0], whole[1:] = _GREY, 128
        for number in range(faces):
            y, x = number // columns * height, number % columns * width
            whole[:, y : y + height, x : x + width] = planes
        return av.VideoFrame.from_ndarray(whole, format="yuv444p").reformat(format="yuv420p")

    write_video(target, map(tiled, pictures(source)), X264_OPTIONS)
    return target
