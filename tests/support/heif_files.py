"""HEIC files as phones write them: ISO/IEC 23008-12 boxes around HEVC pictures by x265."""

import io
import struct
from dataclasses import dataclass, field
from functools import lru_cache

import av
import numpy as np
from av.video.reformatter import ColorRange, Colorspace

GAIN_MAP = "urn:com:apple:photo:2020:aux:hdrgainmap"
TONE_MAP = bytes(5) + b"\x80" + struct.pack(">8I", *(1, 1, 4, 1, 1, 1, 1, 1)) + bytes(80)
FULL_RANGE = 0x80


def heic(
    rgb8,
    *,
    tile_px=None,
    bit_depth=8,
    rotation_degrees=0,
    mirror=None,
    colr=None,
    exif=None,
    gain_map=None,
    aux=GAIN_MAP,
    thumbnail=None,
    further=None,
):
    """The bytes of a HEIC file that shows rgb8 turned counter-clockwise by rotation_degrees.

    tile_px: side of square tiles; None stores one picture.  mirror: after the rotation,
    exchange top and bottom (0) or left and right (1).  colr: content of a `colr` box (`nclx` or
    `icc`).  exif: a TIFF structure.  gain_map, thumbnail: (H, W, 3) uint8, stored as pictures
    beside the primary one; the gain map is tiled if the primary picture is.  aux: the declared
    type of the gain map; "" leaves only the newer form of a gain map.  further: (H, W, 3) uint8,
    one more photo.
    """
    file = _File()
    turns = [*_rotation(rotation_degrees), *_mirror(mirror)]
    shared = [*_colour(colr or nclx(1, 13, 1), bit_depth), *turns]
    primary = file.add_tiled(rgb8, tile_px, bit_depth, shared)
    if thumbnail is not None:
        file.references.append((b"thmb", file.add_picture(thumbnail, 8, turns), [primary]))
    if gain_map is not None:
        kind = [full_box(b"auxC", aux.encode() + b"\0")] if aux else []
        gains = file.add_tiled(gain_map, tile_px, 8, [*kind, *turns])
        if aux:
            file.references.append((b"auxl", gains, [primary]))
        if aux in (GAIN_MAP, ""):
            # since iOS 18 also in the form of ISO 21496-1: an alternative picture made of both
            toned = file.add(b"tmap", TONE_MAP, [_ispe(*rgb8.shape[1::-1]), *turns])
            file.references.append((b"dimg", toned, [primary, gains]))
    if further is not None:
        file.shown.append(file.add_picture(further, 8))
    if exif is not None:
        block = file.add(b"Exif", struct.pack(">I", 0) + exif, [])
        file.references.append((b"cdsc", block, [primary]))
    return file.written(primary)


def nclx(primaries, transfer, matrix, full_range=FULL_RANGE):
    return b"nclx" + struct.pack(">HHHB", primaries, transfer, matrix, full_range)


def icc(profile):
    return b"prof" + profile


def box(name, content):
    return struct.pack(">I", 8 + len(content)) + name + content


def full_box(name, content, version=0, flags=0):
    return box(name, struct.pack(">I", version << 24 | flags) + content)


def padded(rgb8, side_px):
    missing = side_px - rgb8.shape[0], side_px - rgb8.shape[1]
    return np.pad(rgb8, ((0, missing[0]), (0, missing[1]), (0, 0)), mode="edge")


def _ispe(width, height):
    return full_box(b"ispe", struct.pack(">II", width, height))


def _colour(colr, bit_depth):
    return [box(b"colr", colr), full_box(b"pixi", bytes([3, bit_depth, bit_depth, bit_depth]))]


def _rotation(degrees):
    return [box(b"irot", bytes([degrees // 90]))] if degrees else []


def _mirror(axis):
    return [] if axis is None else [box(b"imir", bytes([axis]))]


def _hevc(rgb8, bit_depth):
    """(hvcC record, key frame with lengths before its NAL units) of one full-range picture."""
    return _hevc_of(rgb8.tobytes(), rgb8.shape, bit_depth)


@lru_cache(maxsize=4)  # many tiles are alike
def _hevc_of(pixels, shape, bit_depth):
    rgb8, file = np.frombuffer(pixels, np.uint8).reshape(shape), io.BytesIO()
    pix_fmt = "yuv420p" if bit_depth == 8 else f"yuv420p{bit_depth}le"
    with av.open(file, "w", "mp4") as out:
        stream = out.add_stream("libx265", rate=1, options={
            "preset": "ultrafast",
            "x265-params": "log-level=none:crf=4:keyint=1:info=0:pools=1:frame-threads=1:range=full:colormatrix=bt709",
        })  # fmt: skip
        stream.width, stream.height, stream.pix_fmt = rgb8.shape[1], rgb8.shape[0], pix_fmt
        frame = av.VideoFrame.from_ndarray(rgb8, "rgb24").reformat(
            format=pix_fmt, dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.JPEG
        )
        out.mux([*stream.encode(frame), *stream.encode(None)])
    file.seek(0)
    with av.open(file) as made:
        video = made.streams.video[0]
        packet = next(p for p in made.demux(video) if p.size)
        return bytes(video.codec_context.extradata), bytes(packet)


@dataclass
class _File:
    items: list = field(default_factory=list)  # (kind, data, numbers of properties)
    properties: list = field(default_factory=list)
    references: list = field(default_factory=list)  # (kind, from, [to])
    shown: list = field(default_factory=list)  # numbers of further pictures

    def add(self, kind, data, properties):
        """Add an item; returns its number, which begins at 1."""
        for one in properties:
            if one not in self.properties:
                self.properties.append(one)
        numbers = [self.properties.index(one) + 1 for one in properties]
        self.items.append((kind, data, numbers))
        return len(self.items)

    def add_picture(self, rgb8, bit_depth, properties=()):
        record, data = _hevc(rgb8, bit_depth)
        size = _ispe(rgb8.shape[1], rgb8.shape[0])
        return self.add(b"hvc1", data, [box(b"hvcC", record), size, *properties])

    def add_tiled(self, rgb8, tile_px, bit_depth, properties):
        """Add a picture, in square tiles unless tile_px is None."""
        if tile_px is None:
            return self.add_picture(rgb8, bit_depth, properties)
        height, width = rgb8.shape[:2]
        tiles = [
            self.add_picture(padded(rgb8[y : y + tile_px, x : x + tile_px], tile_px), bit_depth)
            for y in range(0, height, tile_px)
            for x in range(0, width, tile_px)
        ]
        rows, columns = -(-height // tile_px), -(-width // tile_px)
        grid = struct.pack(">BBBBHH", 0, 0, rows - 1, columns - 1, width, height)
        whole = self.add(b"grid", grid, [_ispe(width, height), *properties])
        self.references.append((b"dimg", whole, tiles))
        return whole

    def written(self, primary):
        start = box(b"ftyp", b"heic\0\0\0\0mif1heic")
        length = len(start) + len(self._meta(primary, 0))
        meta = self._meta(primary, length + 8)
        return start + meta + box(b"mdat", b"".join(data for _, data, _ in self.items))

    def _meta(self, primary, data_offset):
        entries, places, links = [], [], []
        for number, (kind, data, numbers) in enumerate(self.items, 1):
            hidden = number not in (primary, *self.shown)
            entry = struct.pack(">HH", number, 0) + kind + b"\0"
            entries.append(full_box(b"infe", entry, 2, int(hidden)))
            places.append(struct.pack(">HHHII", number, 0, 1, data_offset, len(data)))
            data_offset += len(data)
            links.append(
                struct.pack(">HB", number, len(numbers)) + bytes(0x80 | n for n in numbers)
            )
        refs = b"".join(
            box(kind, struct.pack(f">HH{len(to)}H", source, len(to), *to))
            for kind, source, to in self.references
        )
        links_box = full_box(b"ipma", struct.pack(">I", len(links)) + b"".join(links))
        content = full_box(b"hdlr", b"\0\0\0\0pict" + bytes(13))
        content += full_box(b"pitm", struct.pack(">H", primary))
        content += full_box(b"iloc", struct.pack(">BBH", 0x44, 0, len(places)) + b"".join(places))
        content += full_box(b"iinf", struct.pack(">H", len(entries)) + b"".join(entries))
        content += full_box(b"iref", refs) if refs else b""
        content += box(b"iprp", box(b"ipco", b"".join(self.properties)) + links_box)
        return full_box(b"meta", content)
