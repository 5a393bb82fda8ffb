"""The report of a run, for people (`summary`, `warnings`) and for programs (`to_dict`)."""

import time
from dataclasses import asdict, dataclass, field
from typing import Any

from makeup_video.pipeline.engine.machine import peak_memory_bytes
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.faces.face import MIN_FACE_PX


@dataclass(slots=True)
class Report:
    """Counts and times of one run. Seconds are of the wall clock unless the name has "cpu" in it.

    encoder: FFmpeg's name of the encoder.  encoder_note: how it was chosen, where hardware was
    asked for, and a warning where few players can show the output.
    max_pts_error_seconds: the largest distance between a frame's time in the source and in the
    output: 0.0 in mp4 and mov, at most half a millisecond in mkv and webm.
    lost_frames: in the file, but not decodable.
    skipped_packets: damaged packets of other streams.
    dropped: streams and metadata that the output could not hold.  converted: those that it could
    not hold as they were, and times that were moved.
    hardly_played: copied streams that few players can play in the output.
    conversions: changes of the pixel format or the size before painting.
    frames_with_face, faces: how many frames show a face, and how many faces there are in all; None
    in a run that does not find faces.
    tiny_faces: how often a face was left alone because it was too small.
    painted_frames: how many frames were painted; None where nothing was to be painted.
    why_unpainted: why no frame was painted although faces were found, or why some parts of the look
    were not.
    segments: how many the video was painted in.  why_whole: why it was not split as asked.
    media_seconds: the length of the video that was painted, from its first frame on.
    first_packet_unix_seconds: the wall clock when the first packet of video was written.
    peak_memory_bytes: of the process that held the most.
    stages: items, busy_seconds and cpu_seconds of each actor.
    channels: capacity and mean_fill of each channel; empty for a video in segments.
    """

    source: str
    output: str
    codec: str
    encoder: str = ""
    encoder_note: str = ""
    is_picture: bool = False
    frames_in: int = 0
    frames_out: int = 0
    max_pts_error_seconds: float = 0.0
    mended_times: int = 0
    corrupt_frames: int = 0
    lost_frames: int = 0
    decode_errors: int = 0
    skipped_packets: int = 0
    truncated: bool = False
    damaged: bool = False
    dropped: list[str] = field(default_factory=list)
    converted: list[str] = field(default_factory=list)
    hardly_played: list[str] = field(default_factory=list)
    conversions: list[str] = field(default_factory=list)
    frames_with_face: int | None = None
    faces: int | None = None
    tiny_faces: int = 0
    painted_frames: int | None = None
    why_unpainted: str = ""
    segments: int = 1
    why_whole: str = ""
    seconds: float = 0.0
    media_seconds: float = 0.0
    first_packet_unix_seconds: float | None = None
    cpu_seconds: float = 0.0
    stages: dict[str, dict[str, float]] = field(default_factory=dict)
    channels: dict[str, dict[str, float]] = field(default_factory=dict)
    bytes_in: int = 0
    bytes_out: int = 0
    peak_memory_bytes: int = 0

    @property
    def frames_per_second(self) -> float:
        return self.frames_out / self.seconds if self.seconds else 0.0

    @property
    def times_real_time(self) -> float:
        return self.media_seconds / self.seconds if self.seconds else 0.0

    def to_dict(self) -> dict[str, Any]:
        """The report as JSON values."""
        speed = {"fps": self.frames_per_second, "times_real_time": self.times_real_time}
        return {**asdict(self), **speed}

    def warnings(self) -> list[str]:
        """One line for everything that differs from the source, or was not painted."""
        lines = [f"changed: {text}" for text in (*self.conversions, *self.converted)]
        lines += [f"dropped: {text}" for text in self.dropped]
        lines += self.hardly_played
        if self.encoder_note:
            lines.append(f"encoder: {self.encoder_note}")
        if self.why_whole:
            lines.append(f"not split: {self.why_whole}")
        if self.damaged:
            lines.append(self._damage())
        if self.painted_frames == 0 and self.frames_with_face:
            lines.append(f"nothing was painted: {self.why_unpainted}")
        elif self.painted_frames == 0:
            turn = "" if self.tiny_faces else f"; {self.turn_first}"
            lines.append(f"no face was found: nothing was painted{turn}")
        elif self.why_unpainted:
            lines.append(f"not all was painted: {self.why_unpainted}")
        elif self.frames_with_face == 0:
            lines.append("no face was found")
        if self.tiny_faces:
            lines.append(
                f"faces under {MIN_FACE_PX} px wide were not painted ({self.tiny_faces} seen)"
            )
        return lines

    @property
    def turn_first(self) -> str:
        """Advice for videos stored upside down, where faces are found less often."""
        return f"if the {'picture' if self.is_picture else 'video'} is upside down, turn it first"

    def _damage(self) -> str:
        counts = {
            ("frame", "damaged"): self.corrupt_frames,
            ("frame", "lost"): self.lost_frames,
            ("packet", "not decodable"): self.decode_errors,
            ("packet", "of other streams left out"): self.skipped_packets,
        }
        parts = [
            f"{count} {noun}{'' if count == 1 else 's'} {what}"
            for (noun, what), count in counts.items()
            if count
        ]
        if self.truncated:
            parts.insert(0, "the file ends early")
        return "the input is damaged: " + ", ".join(parts)

    @property
    def size_in_words(self) -> str:
        """How much was written: "300 frames, 1.2 MB"."""
        count = "one picture" if self.is_picture else frames_in_words(self.frames_out)
        return f"{count}, {size_in_words(self.bytes_out)}"

    def summary(self) -> str:
        """The last line of a run."""
        if self.is_picture:
            return f"{self.output}: {self.size_in_words}"
        return (
            f"{self.output}: {frames_in_words(self.frames_out)} in {self.seconds:.1f} s "
            f"({self.frames_per_second:.0f} fps, {self.times_real_time:.1f}x real time), "
            f"{size_in_words(self.bytes_out)}"
        )


Outcome = Report | MakeupVideoError  # of one of several outputs


class RunClock:
    """Measures a run of this process from here on."""

    def __init__(self) -> None:
        self._began, self._cpu_began = time.monotonic(), time.process_time()

    def write(self, *reports: Report) -> None:
        """Write the run's times so far and the process's memory into its reports."""
        seconds = time.monotonic() - self._began
        cpu_seconds = time.process_time() - self._cpu_began
        for report in reports:
            report.seconds, report.cpu_seconds = seconds, cpu_seconds
            report.peak_memory_bytes = peak_memory_bytes()


def frames_in_words(count: int) -> str:
    return f"{count} frame{'' if count == 1 else 's'}"


def size_in_words(count: int) -> str:
    """A count of bytes, as in "1.2 MB"."""
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"
