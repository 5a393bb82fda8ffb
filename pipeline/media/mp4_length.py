"""Makes the track of a video in mp4 and mov as long as its pictures: ISO/IEC 14496-12, 8.6.1.2."""

from typing import Any


class TrackLength:
    """Gives the packet that is decoded last the rest of the track's length.

    mp4 stores the steps between decoding times, and readers take their sum for the length of the
    track. With B-frames the picture decoded last need not be the one shown last, so where pictures
    stand still the sum ends seconds too early.
    """

    def __init__(self) -> None:
        self._held: Any = None
        self._early = 0  # by how much decoding begins before the first picture is shown
        self._end: int | None = None  # of the picture shown last; all in ticks of the packets

    def __call__(self, packet: Any) -> list[Any]:
        """Take a packet; return the one before it, or this one if it has no decoding time."""
        if packet.dts is None:  # FFmpeg's muxer finds the decoding times
            return [packet]
        end = packet.pts + packet.duration
        if self._end is None:
            self._early, self._end = packet.pts - packet.dts, end
        self._end = max(self._end, end)
        before, self._held = self._held, packet
        return [] if before is None else [before]

    def finish(self) -> list[Any]:
        """The last packet, lengthened where the track would be too short.

        Its picture ends no later than the video, since headers count up to the end of each picture.
        If the track is then still too short, the packet's decoding time moves later, at most to the
        time at which its picture is shown.
        """
        packet, self._held = self._held, None
        if packet is None or self._end is None:
            return []
        missing = self._end - self._early - packet.dts - packet.duration
        if missing > 0:
            longer = min(missing, self._end - packet.pts - packet.duration)
            packet.duration += longer
            packet.dts += missing - longer
        return [packet]
