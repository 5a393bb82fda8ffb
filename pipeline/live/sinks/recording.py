"""The pictures of a live run -> a file, which is complete whenever the run is stopped."""

import contextlib
import os
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.files.output_file import (
    OutputFile,
    check_place,
    part_of,
    write_errors,
)
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks.encoder import LiveEncoder
from makeup_video.pipeline.live.sinks.sound_encoder import SoundEncoder, sound_in_words
from makeup_video.pipeline.live.sound import SoundTap
from makeup_video.pipeline.media.codecs import MATROSKA, container_of, encoder_options, pick_codec
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat


class Recording:
    """Writes each picture with its time of arrival, counted from the first picture.

    Dropped frames leave gaps, so the file lasts as long as the run.
    path: .mp4, .m4v, .mov, .mkv or .webm. The file grows as NAME.part.EXT and gets its name when
    the run is stopped.
    source: the file that is played as the camera; None for a device.
    rate: expected frames per second, for rate control alone.
    sound: the run's sound, which is recorded as well; None: no sound.
    Raises UsageError or OutputError before anything is written. A call raises EncodeError or
    OutputError, or DecodeError for a picture of another size. The recording so far then stays as
    the part file.
    """

    kind = "recording"
    waiting = 15  # encoders work in bursts
    notice = ""  # always empty: a recording that fails ends with an error

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        overwrite: bool = False,
        rate: Fraction | float = 30,
        source: Path | None = None,
        sound: SoundTap | None = None,
    ) -> None:
        self.name = Path(path).name
        self._format = container_of(path)
        self._codec = pick_codec(None, self._format, deep=False, alpha=False)
        self._options = encoder_options(self._codec, None, self._codec.live_preset)
        self._options.update(self._codec.live_options)
        self._rate = Fraction(rate).limit_denominator(1001)
        self._convert = ConvertPixelFormat(self._codec)
        check_place(os.fspath(path), source, overwrite=overwrite)
        self._path, self._source, self._overwrite = Path(path), source, overwrite
        self._part = part_of(self._path)
        # made with the first picture, so a run without pictures leaves no file
        self._target: OutputFile | None = None
        self._container: Any = None
        self._encoder: LiveEncoder | None = None
        self._sound = sound
        self._sound_encoder: SoundEncoder | None = None
        self._state: str | None = None  # the final state, once the recording has ended
        self._began = self._seconds = 0.0
        self.sent = 0

    @property
    def state(self) -> str:
        """What the file holds, for the last line: its length, and the source of its sound."""
        if self._state is not None:
            return self._state
        return f", {self._seconds:.1f} s{sound_in_words(self._sound, self._sound_encoder)}"

    @property
    def seconds(self) -> float:
        """Length of the recording so far."""
        return self._seconds

    def __call__(self, picture: LivePicture) -> None:
        try:
            self._write(self._converted(picture.frame))
        except Exception as error:
            self._leave(error)
            raise

    def _converted(self, frame: Frame) -> Frame:
        converted = self._convert(frame.picture)
        if converted is frame.picture:
            return frame
        tags = ColourTags.of(converted)
        return Frame(converted, frame.pts, frame.time_base, tags, frame.rotation_degrees)

    def finish(self) -> None:
        """Flush the encoder, close the file and rename it. Without any picture there is no file."""
        if self._sound is not None:
            self._sound.close()
        if self._encoder is None or self._target is None:
            return
        try:
            with write_errors(self._part):
                self._mux(self._encoder(None))
                if self._sound_encoder is not None:
                    self._mux(self._sound_encoder.flush())
                self._container.close()
                self._target.keep()
        except Exception as error:
            self._leave(error)
            raise
        self._release()

    def _release(self) -> None:
        """Free the encoders, which hold frames and threads: the run keeps its recordings."""
        self._state = self.state
        self._container = self._encoder = self._sound_encoder = None

    def _write(self, frame: Frame) -> None:
        with write_errors(self._part):
            if self._encoder is None:
                self._target = OutputFile(self._path, self._source, overwrite=self._overwrite)
                self._encoder = self._open(self._target.own_path, frame)
                self._began = frame.seconds
            self._mux(self._encoder(frame.picture))
            if self._sound_encoder is not None:
                self._mux(self._sound_encoder(frame.seconds))
        self._seconds = frame.seconds - self._began
        self.sent += 1

    def _mux(self, packets: Any) -> None:
        for packet in packets:
            self._container.mux_one(packet)

    def _open(self, path: Path, frame: Frame) -> LiveEncoder:
        # An MP4 or MOV grows in fragments of two seconds, so it plays even when it is cut off. It
        # becomes an ordinary file when it is closed.
        options = {"movflags": "+hybrid_fragmented", "frag_duration": "2000000"}
        options["video_track_timescale"] = "90000"
        if self._format in MATROSKA:
            options = {}
        self._container = av.open(
            f"file:{path}",
            "w",
            format=self._format,
            container_options=options,
        )
        encoder = LiveEncoder(
            self._container, self._codec.encoder, self._options, frame, self._rate
        )
        if self._sound is not None:
            self._sound_encoder = SoundEncoder(
                self._container,
                self._format,
                self._sound,
                frame.seconds,
                global_header=self._format not in MATROSKA,
            )
        self._container.start_encoding()
        return encoder

    def _is_empty(self) -> bool:
        """True when the disk was full from the start.

        Nothing is in the file then, although some pictures were encoded: they waited in memory.
        """
        try:
            return self._part.stat().st_size == 0
        except OSError:  # somebody else removed the file
            return False

    def _leave(self, error: Exception) -> None:
        """Close the file as well as possible, and add the name of the part file to the error.

        A part file without any picture is deleted.
        """
        if self._sound is not None:
            self._sound.close()
        with contextlib.suppress(Exception):
            self._container.close()
        self._release()
        if self._target is None:
            return
        if not self.sent or self._is_empty():
            self._target.discard()
            return
        self._target.leave()
        if isinstance(error, MakeupVideoError):
            error.extend(after=f"; the recording so far is {self._part}")
