"""Cameras faked by the packets of a clip."""

from fractions import Fraction

import av
from media import make_clip, picture


class FakeDevice:
    """Stands in for the container that FFmpeg opens: gives the packets of a clip after `begin`,
    then calls `end`."""

    def __init__(self, path, end, begin=None):
        self.file = av.open(str(path))
        self.streams = self.file.streams
        self.end, self.begin = end, begin
        self.closed = False

    def demux(self, video):
        if self.begin:
            self.begin.wait(20)
        for packet in self.file.demux(video):
            if packet.size:
                yield self.changed(packet)
        self.end()

    def changed(self, packet):
        return packet

    def close(self):
        self.closed = True
        self.file.close()


def unplugged():
    raise OSError(19, "No such device")


def mjpeg(tmp_path, name="cam.avi", **more):
    more = {"frames": 6, "pix_fmt": "yuvj422p", "size_wh": (64, 48), **more}
    return make_clip(tmp_path / name, "mjpeg", **more)


class Damaged(FakeDevice):
    """One packet is cut short, one is no JPEG, one is empty, and one has garbage after its end."""

    def changed(self, packet):
        data = bytes(packet)
        number = packet.pts
        odd = {1: data[: len(data) // 2], 3: b"no picture", 5: b"", 6: data + b"rubbish"}
        cut = odd.get(number, data)
        return av.Packet(cut)  # no time stamp: on a busy machine, stale packets would be dropped


def raw_yuyv(path, frames=4, size_wh=(64, 48)):
    """Raw YUYV, as from a camera, in AVI."""
    with av.open(str(path), "w") as out:
        stream = out.add_stream("rawvideo", rate=10)
        stream.width, stream.height, stream.pix_fmt = *size_wh, "yuyv422"
        for index in range(frames):
            shown = picture(index, *size_wh, "yuyv422")
            shown.pts, shown.time_base = index, Fraction(1, 10)
            out.mux(stream.encode(shown))
    return path


class Scripted(FakeDevice):
    """Gives its packets at scripted times with scripted stamps: script is [(stamp, read), ...]."""

    def __init__(self, path, end, begin, clock, script):
        super().__init__(path, end, begin)
        self.clock, self.script = clock, script

    def demux(self, video):
        self.begin.wait(20)
        for packet, (stamped, read) in zip(self.file.demux(video), self.script, strict=False):
            out = av.Packet(bytes(packet))
            out.pts, out.time_base = round((7000 + stamped) * 1e6), Fraction(1, 1_000_000)
            self.clock[0] = read
            yield out
        self.end()
