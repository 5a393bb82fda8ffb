"""The pictures of a live run -> a receiver on the network: RTMP, SRT or MPEG-TS over UDP."""

import contextlib
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Any
from urllib.parse import urlsplit

import av
from av.video.frame import PictureType
from makeup_video.pipeline.errors import (
    EncodeError,
    OutputError,
    UsageError,
    is_of_the_system,
    option,
    reason_of,
)
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.transform import copied, upright
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE, LivePicture
from makeup_video.pipeline.live.sinks.encoder import LiveEncoder
from makeup_video.pipeline.live.sinks.sound_encoder import SoundEncoder
from makeup_video.pipeline.live.sinks.srt_relay import (
    TIMEOUT_SECONDS,
    SrtRelay,
    needs_relay,
    relay_program,
)
from makeup_video.pipeline.live.sound import SoundTap
from makeup_video.pipeline.media.codecs import PLAYS_EVERYWHERE

_FORMATS = {"rtmp": "flv", "rtmps": "flv", "srt": "mpegts", "udp": "mpegts"}
_KEY_SECONDS = 2
_LONGEST_PAUSE_SECONDS = 30.0
_STEADY_SECONDS = 10  # after a connection that held this long, the next pause is short again
_UDP_BYTES = 1316  # seven packets of MPEG-TS, which fit into a datagram on any network
_BIT_RATE_720P = 3_000_000
# zerolatency: no look-ahead, no B-frames, and threads work on slices of one frame, not on frames
_OPTIONS = {"preset": str(PLAYS_EVERYWHERE.live_preset), "tune": "zerolatency", "forced-idr": "1"}


class Stream:
    """Sends the pictures as H.264, upright, without added delay, and with a key frame every 2 s.

    While the receiver is away, the sink drops the pictures and tries to connect again after pauses
    that grow.
    url: rtmp://, rtmps://, srt:// or udp://, opened with the first picture. Messages show only its
    scheme and host, since the rest may contain a key.
    rate: expected frames per second.
    sound: the run's sound, which is sent as well; None: no sound.
    log: called with a line of text when the receiver is away, and when it is back.
    Raises UsageError for another scheme or a URL without a host, and InstallError when SRT needs an
    ffmpeg that this machine does not have.
    """

    kind = "stream"
    waiting = 2

    def __init__(
        self,
        url: str,
        *,
        log: Callable[[str], None],
        rate: Fraction | float = 30,
        sound: SoundTap | None = None,
    ) -> None:
        self.name, self._format = _checked(url)
        self._url, self._log = url, log
        self._relay_program = relay_program(self.name) if needs_relay(url) else None
        self._rate = Fraction(rate).limit_denominator(1001)
        self._sound = sound
        self._connection: _Connection | None = None
        self._pause = 1.0
        self._next_try = 0.0
        self._sent_before = 0  # pictures sent on connections that are closed now
        self._reason = ""  # why the last connection failed
        self.notice = ""

    @property
    def sent(self) -> int:
        """Number of pictures that a receiver took.

        Pictures written to an SRT relay count once the relay has held for some seconds, or has
        ended well: before that it may have no connection.
        """
        current = self._connection  # read once: another thread may replace it
        return self._sent_before + (current.pictures if current and current.is_proven else 0)

    @property
    def seconds(self) -> float:
        current = self._connection  # read once: another thread may replace it
        return current.seconds if current and current.is_proven else 0.0

    @property
    def state(self) -> str:
        """The source of the sound that was sent, and what is wrong now."""
        sound = "without audio" if self._sound is None else f"with audio from {self._sound.name}"
        return f", {sound}; {self._reason}" if self.notice else f", {sound}"

    def __call__(self, picture: LivePicture) -> None:
        """Send a picture. Raises EncodeError when the encoder refuses it."""
        if self._connection is None and time.monotonic() < self._next_try:
            return
        try:
            if self._connection is None:
                self._connection = self._connect(picture.frame)
            self._connection.send(picture.frame)
        except EncodeError:  # EncodeError is an OSError, too, but a new connection would not help
            self._hang_up()
            self._end_sound()
            raise
        except (av.FFmpegError, OSError) as error:
            self._failed(error)
            return
        if self._connection.seconds > _STEADY_SECONDS:
            self._pause = 1.0
        if self.notice and self._connection.is_proven:
            self.notice = ""
            self._log(f"{self.name}: sending")

    def finish(self) -> None:
        """Close the connection. Raises OutputError when the whole run could send no picture."""
        was_open = self._connection is not None
        self._hang_up()
        self._end_sound()
        if not self._sent_before and (was_open or self._reason):
            raise OutputError(
                f"{self.name}: {self._reason or 'no connection'}; no frame was sent in the whole "
                "run: check the address, and whether the receiver listens"
            )

    def _end_sound(self) -> None:
        if self._sound is not None:
            self._sound.close()

    def _hang_up(self) -> None:
        if self._connection is not None:
            self._connection.close()
            if self._connection.is_proven:
                self._sent_before += self._connection.pictures
            self._connection = None

    def _connect(self, frame: Frame) -> "_Connection":
        bit_rate = bit_rate_for(frame.width_px * frame.height_px)
        relay = self._relay_program and SrtRelay(self._relay_program, self._url)
        return _Connection(
            self._url, self._format, relay or None, frame, self._rate, bit_rate, self._sound
        )

    def _failed(self, error: Exception) -> None:
        self._hang_up()
        self._reason = _reason(error)
        self._next_try = time.monotonic() + self._pause
        self._pause = min(2 * self._pause, _LONGEST_PAUSE_SECONDS)
        if not self.notice:
            self.notice = f"{self.name}: {self._reason}; trying again"
            self._log(self.notice)


def _reason(error: Exception) -> str:
    """Return the system's message alone, since FFmpeg's whole message would show the address."""
    return reason_of(error) if is_of_the_system(error) else "no connection"


def bit_rate_for(pixels: int) -> int:
    """Choose bits per second: 3 million at 720p, 5.5 million at 1080p. More pixels: less each."""
    return int(_BIT_RATE_720P * float((pixels / (1280 * 720)) ** 0.75))


class _Connection:
    """One connection: encoder, container and relay. Raises FFmpeg's errors, or OSError."""

    def __init__(
        self,
        url: str,
        format_name: str,
        relay: "SrtRelay | None",
        frame: Frame,
        rate: Fraction,
        bit_rate: int,
        sound: SoundTap | None,
    ) -> None:
        self._relay = relay
        self._sound: SoundEncoder | None = None
        self._container: Any = None
        self._began = time.monotonic()
        self._key_at = frame.pts
        self.pictures = 0
        try:
            self._container = _container(url, format_name, relay)
            options = {**_OPTIONS, "maxrate": str(bit_rate), "bufsize": str(bit_rate)}
            options["g"] = str(round(_KEY_SECONDS * 5 * rate))  # `send` asks for them earlier
            flv = format_name == "flv"
            turned = Frame(upright(frame), frame.pts, frame.time_base, frame.tags)
            self._encoder = LiveEncoder(
                self._container,
                PLAYS_EVERYWHERE.encoder,
                options,
                turned,
                rate,
                bit_rate=bit_rate,
                global_header=flv,
                at_once=True,
            )
            if sound is not None:
                self._sound = SoundEncoder(
                    self._container, format_name, sound, frame.seconds, global_header=flv
                )
            self._container.start_encoding()
        except BaseException:
            self.close()
            raise

    @property
    def seconds(self) -> float:
        """How long the connection has held."""
        return time.monotonic() - self._began

    @property
    def is_proven(self) -> bool:
        """False while a relay may still fail: it takes all data until it gives up connecting.

        A connection without a relay is proven at once.
        """
        if self._relay is None or self._relay.has_sent_all:
            return True
        return self.seconds > TIMEOUT_SECONDS

    def send(self, frame: Frame) -> None:
        picture = upright(frame)
        if frame.pts >= self._key_at:
            self._key_at = frame.pts + _KEY_SECONDS * LIVE_TIME_BASE.denominator
            if picture is frame.picture:
                picture = copied(picture)  # the other sinks use the same picture
            picture.pict_type = PictureType.I
        for packet in self._encoder(picture):
            self._container.mux_one(packet)
        if self._sound is not None:
            for packet in self._sound(frame.seconds):
                self._container.mux_one(packet)
        self.pictures += 1

    def close(self) -> None:
        """Close encoder and relay. Never raises, since the receiver may be gone."""
        with contextlib.suppress(Exception):
            if self._container is not None:
                self._container.close()
        if self._relay is not None:
            self._relay.close()


def _container(url: str, format_name: str, relay: "SrtRelay | None") -> Any:
    if relay is not None:
        return av.open(relay, "w", format=format_name)
    if format_name == "flv":
        # PyAV cannot pass options to an output's connection, but FFmpeg's tee muxer can
        micros = TIMEOUT_SECONDS * 1_000_000
        options = f"f=flv:onfail=abort:rw_timeout={micros}:flvflags=no_duration_filesize"
        return av.open(f"[{options}]{_escaped(url)}", "w", format="tee")
    joined = "&" if "?" in url else "?"
    sized = url if "pkt_size=" in url else f"{url}{joined}pkt_size={_UDP_BYTES}"
    return av.open(sized, "w", format=format_name, container_options={"flush_packets": "1"})


def _escaped(url: str) -> str:
    """Escape an address for FFmpeg's tee muxer."""
    return "".join(f"\\{letter}" if letter in "\\'|[] " else letter for letter in url)


def _checked(url: str) -> tuple[str, str]:
    """Return the part of a URL that may be shown, and FFmpeg's format. Raises UsageError."""
    try:
        parts = urlsplit(url)
        host, scheme = parts.hostname, parts.scheme.lower()
    except ValueError:
        host, scheme = None, ""
    if scheme not in _FORMATS:
        raise UsageError(
            f"{option('url')} must begin with one of {', '.join(f'{s}://' for s in _FORMATS)}, "
            f"got {f'an address with {scheme}:' if scheme else 'an address without a scheme'}"
        )
    if not host or any(ord(letter) <= 32 for letter in url):
        raise UsageError(f"{option('url')} names no host: give {scheme}://HOST/PATH")
    return f"{scheme}://{f'[{host}]' if ':' in host else host}", _FORMATS[scheme]
