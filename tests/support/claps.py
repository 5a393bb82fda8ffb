"""Videos whose picture flashes when their sound claps."""

from fractions import Fraction

import av
import numpy as np

FPS, RATE = 30, 44_100


def clap_clip(path, seconds, *, sound_seconds=None):
    """Write a video with a flash of two frames and a clap at each whole second but 0."""
    count = round((sound_seconds or seconds) * RATE)
    sound = np.zeros((1, count), np.float32)
    for second in range(1, seconds):
        sound[0, second * RATE : second * RATE + 441] = 0.8 * np.sin(np.arange(441) * 0.5)
    with av.open(str(path), "w") as out:
        video, audio = out.add_stream("h264", rate=FPS), out.add_stream("aac", rate=RATE)
        video.width, video.height, video.pix_fmt, audio.layout = 64, 48, "yuv420p", "mono"
        step = RATE // FPS
        for number in range(seconds * FPS):
            is_flash = number >= FPS and number % FPS < 2
            grey = np.full((48, 64, 3), 240 if is_flash else 30, np.uint8)
            picture = av.VideoFrame.from_ndarray(grey, format="rgb24")
            picture.pts = number
            out.mux(video.encode(picture))
            out.mux(audio.encode(_frame(sound, number * step, step)))
        out.mux(video.encode(None))
        out.mux(audio.encode(None))
    return path


def _frame(sound, at, count):
    part = np.ascontiguousarray(sound[:, at : at + count])
    if not part.shape[1]:
        part = np.zeros((1, 1), np.float32)
    frame = av.AudioFrame.from_ndarray(part, "fltp", "mono")
    frame.sample_rate, frame.pts, frame.time_base = RATE, at, Fraction(1, RATE)
    return frame


def marks(path):
    """Seconds at which the picture flashes, and at which the sound claps.

    A video that begins within a flash may lack its clap, so the first picture never counts as one.
    """
    flashes, claps, last = [], [], 255.0
    with av.open(str(path)) as container:
        for picture in container.decode(video=0):
            bright = picture.to_ndarray(format="gray").mean()
            if bright > 120 >= last:
                flashes.append(picture.time)
            last = bright
    with av.open(str(path)) as container:
        for frame in container.decode(audio=0):
            loud = np.abs(frame.to_ndarray().reshape(len(frame.layout.channels), -1)).max(0) > 0.3
            for at in np.flatnonzero(loud):
                seconds = frame.time + at / frame.sample_rate
                if not claps or seconds - claps[-1] > 0.3:
                    claps.append(seconds)
    return flashes, claps
