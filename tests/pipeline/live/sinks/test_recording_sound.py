"""Recordings with sound: flashes and claps stay together, whatever the sound card's clock does."""

import av
import numpy as np
import pytest
from claps import marks
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks.recording import Recording
from makeup_video.pipeline.live.sound import RATE, SoundBlock, SoundTap
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera

ZERO = 55555.123
FPS = 5
EVERY_S = 10  # seconds between a flash with its clap and the next
BLOCK = 4800


def pictures(seconds):
    door = NormaliseCamera(is_device=True)
    for number in range(seconds * FPS):
        is_flash = number and number % (EVERY_S * FPS) == 0
        plain = np.full((48, 64, 3), 240 if is_flash else 30, np.uint8)
        frame = av.VideoFrame.from_ndarray(plain, format="rgb24").reformat(format="yuv420p")
        yield LivePicture(door(frame, ZERO + number / FPS))


def blocks(seconds, faster):
    """Blocks, up to 20 ms late, of a sound card whose clock is too fast by the share `faster`."""
    random, rate = np.random.default_rng(1), RATE * (1 + faster)
    loud = np.array([round(at * rate) for at in range(EVERY_S, seconds, EVERY_S)], int)
    wave = (0.8 * np.sin(np.arange(480) * 0.5)).astype(np.float32)
    sound = np.zeros(int(seconds * rate) + RATE, np.float32)
    for at in loud:
        sound[at : at + 480] = wave
    for first in range(0, len(sound) - BLOCK, BLOCK):
        taken = ZERO + first / rate
        yield SoundBlock(sound[None, first : first + BLOCK], taken + 0.02 * random.random())


def off_ms(path, seconds, faster):
    """Milliseconds between each flash and its clap in a recording."""
    tap = SoundTap("card", 1)
    recording, coming = Recording(path, sound=tap), blocks(seconds, faster)
    block = next(coming)
    for picture in pictures(seconds):
        while block and block.begins_seconds + BLOCK / RATE <= picture.frame.seconds:
            tap.put(block)
            block = next(coming, None)
        recording(picture)
    recording.finish()
    flashes, claps = marks(path)
    assert len(flashes) == len(claps) == (seconds - 1) // EVERY_S
    return 1000 * np.abs(np.subtract(claps, flashes))


@pytest.mark.parametrize("faster", [2e-4, -2e-4])
def test_a_minute_of_a_card_with_a_wrong_clock_stays_in_step(tmp_path, faster):
    assert off_ms(tmp_path / "out.mkv", 61, faster).max() < 20


@pytest.mark.slow
@pytest.mark.parametrize("faster", [2e-4, -2e-4])
@pytest.mark.parametrize("end", ["mkv", "mp4"])
def test_ten_minutes_of_such_a_card_stay_in_step(tmp_path, faster, end):
    assert off_ms(tmp_path / f"out.{end}", 601, faster).max() < 20
