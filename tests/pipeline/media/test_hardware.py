"""Encoders of graphics chips. Where a test needs one, x264 stands in for it at FFmpeg's boundary."""

from fractions import Fraction

import av
import pytest
from makeup_video.pipeline import EncodeError, Settings, UsageError, process_video
from makeup_video.pipeline.media import encode, hardware
from makeup_video.pipeline.media.codecs import CODECS, VideoCodec
from makeup_video.pipeline.media.hardware import HARDWARE, EncoderNeeds, pick_encoder
from makeup_video.pipeline.media.pixel_format import bits_of
from media import decoded, make_clip

H264, HEVC = CODECS["h264"], CODECS["hevc"]
VIDEO = EncoderNeeds((256, 144), "yuv420p")


def lists(monkeypatch, *names):
    """Let FFmpeg list no hardware encoders but these."""
    listed = {codec.encoder for codec in CODECS.values()} | set(names)
    monkeypatch.setattr(av, "codecs_available", listed)


@pytest.fixture
def broken(monkeypatch):
    """FFmpeg lists NVENC and QSV, but the machine has a chip for neither."""
    lists(monkeypatch, "h264_nvenc", "hevc_nvenc", "h264_qsv", "hevc_qsv")

    def add_stream(container, row, rate):
        if row.is_hardware:
            raise av.error.PermissionError(1, "Operation not permitted")
        return container.add_stream(row.encoder, rate=rate)

    monkeypatch.setattr(hardware, "add_stream", add_stream)


@pytest.fixture
def working(monkeypatch):
    """NVENC seems to work: x264 stands in for it, and in trials rawvideo, which takes any format.

    Returns the streams of all trials and videos.
    """
    lists(monkeypatch, "h264_nvenc", "hevc_nvenc")
    stand_in = HARDWARE["nvenc"]._replace(options=lambda crf, preset: {"crf": str(crf)})
    monkeypatch.setitem(HARDWARE, "nvenc", stand_in)
    streams = []

    def add(encoder):
        def add_stream(container, row, rate):
            streams.append(container.add_stream(encoder, rate=rate))
            return streams[-1]

        return add_stream

    monkeypatch.setattr(hardware, "add_stream", add("rawvideo"))
    monkeypatch.setattr(encode, "add_stream", add("libx264"))
    return streams


def formats(streams):
    return [stream.codec_context.pix_fmt for stream in streams]


def painted(tmp_path, name, **settings):
    src = make_clip(tmp_path / "in.mp4", frames=6, width=256, height=144)
    report = process_video(src, tmp_path / "out.mp4", None, Settings(hardware=name, **settings))
    assert len(decoded(tmp_path / "out.mp4")) == 6
    return report


def test_no_hardware_is_the_default(working, tmp_path):
    assert Settings().hardware == "none" and pick_encoder(H264, "none", VIDEO) == (H264, "")
    report = painted(tmp_path, "none")
    assert report.encoder == "libx264" and report.encoder_note == ""
    assert formats(working) == ["yuv420p"]  # of the video; there is no trial


@pytest.mark.parametrize("name", ["auto", "nvenc"])
def test_an_encoder_that_works_is_used_and_named(working, tmp_path, name):
    report = painted(tmp_path, name)
    assert report.codec == "h264" and report.encoder == "h264_nvenc"
    assert report.warnings() == ["encoder: h264_nvenc"]
    assert formats(working) == ["nv12", "nv12"]  # of the trial and of the video


def test_what_does_not_work_is_left_for_the_usual_encoder(broken, tmp_path):
    report = painted(tmp_path, "auto")
    assert report.encoder == "libx264"
    (line,) = report.warnings()
    assert line.startswith("encoder: libx264, since no hardware encoder works here (nvenc: ")
    assert "qsv: Operation not permitted" in line and "vaapi" not in line


def test_a_named_encoder_that_does_not_work_is_an_error(broken, tmp_path):
    with pytest.raises(EncodeError, match=r"nvenc: Operation not permitted\. Choose auto"):
        painted(tmp_path, "nvenc")
    with pytest.raises(EncodeError, match="this FFmpeg has no h264_vaapi"):
        painted(tmp_path, "vaapi")
    assert not (tmp_path / "out.mp4").exists() and not list(tmp_path.glob("*.part*"))


def test_an_encoder_that_opens_and_encodes_nothing_is_left(working, monkeypatch):
    class Silent:
        def __init__(self, stream):
            self.codec_context, self.options = stream.codec_context, {}

        def encode(self, frame):
            return []

    def add_stream(container, row, rate):
        return Silent(container.add_stream("libx264", rate=rate))

    monkeypatch.setattr(hardware, "add_stream", add_stream)
    codec, note = pick_encoder(H264, "auto", VIDEO)
    assert codec is H264 and "nvenc: it encodes nothing" in note


@pytest.mark.parametrize(
    ("wanted", "reason"),
    [
        (VIDEO._replace(interlaced=True), "fields of an interlaced video"),
        (VIDEO._replace(preset="veryfast"), "(nvenc: it has no preset veryfast)"),
        (VIDEO._replace(depth=10), "(nvenc: it has no 10 bits)"),
    ],
)
def test_auto_leaves_what_cannot_do_the_video(working, wanted, reason):
    codec, note = pick_encoder(H264, "auto", wanted)
    assert codec is H264 and reason in note and working == []


def test_a_named_encoder_takes_its_own_presets_alone(working):
    assert pick_encoder(H264, "nvenc", VIDEO._replace(preset="p1"))[1] == "h264_nvenc"
    with pytest.raises(UsageError, match="preset must be one of p1, "):
        pick_encoder(H264, "nvenc", VIDEO._replace(preset="veryfast"))


def test_ten_bits_are_handed_over_as_the_chip_wants_them(working):
    codec, note = pick_encoder(HEVC, "auto", VIDEO._replace(pix_fmt="yuv420p10le"))
    assert note == codec.encoder == "hevc_nvenc" and formats(working) == ["p010le"]


@pytest.mark.parametrize("name", ["av1", "vp9", "ffv1", "prores"])
def test_codecs_with_another_scale_of_quality_have_none(working, name):
    codec, note = pick_encoder(CODECS[name], "auto", VIDEO)
    assert codec is CODECS[name] and note.startswith(codec.encoder)


@pytest.mark.parametrize("name", HARDWARE)
@pytest.mark.parametrize("codec", [H264, HEVC], ids=lambda codec: codec.name)
def test_a_row_of_hardware_is_complete(monkeypatch, name, codec):
    lists(monkeypatch, f"{codec.name}_{name}")
    row = hardware.on_hardware(codec, HARDWARE[name])
    assert isinstance(row, VideoCodec) and row.encoder == f"{codec.name}_{name}"
    assert row.preset in (row.presets or ("",)) and row.tag == codec.tag
    for ours, its in row.handed:
        assert ours in codec.pix_fmts and bits_of(ours) == bits_of(its)
    for crf in (0, 18, 51):
        assert all(map(str.isprintable, row.options(crf, row.preset).values()))


@pytest.mark.parametrize("name", HARDWARE)
def test_ffmpeg_knows_the_options_that_we_give(name):
    """A wrong value is refused as an argument, before the chip is looked for."""
    for codec in (H264, HEVC):
        row = hardware.on_hardware(codec, HARDWARE[name])
        if row is None:
            continue  # an encoder of another system
        for preset in row.presets or ("",):
            assert refusal(row, row.options(18, preset)) != "Invalid argument"
        assert refusal(row, {"preset": "no such"}) == "Invalid argument"


def refusal(row, options):
    context = av.CodecContext.create(row.encoder, "w")
    context.width, context.height, context.pix_fmt = 256, 144, "nv12"
    context.time_base, context.options = Fraction(1, 30), options
    try:
        context.open()
    except av.FFmpegError as error:
        return error.strerror
    return ""


def test_machines_list_the_hardware_that_works(working):
    assert dict(hardware.hardware_found()) == {"nvenc": "h264_nvenc, hevc_nvenc"}


def test_machines_without_hardware_list_none(broken):
    assert dict(hardware.hardware_found()) == {}


def test_other_names_and_segments_are_refused():
    with pytest.raises(UsageError, match="hardware must be one of auto, none, videotoolbox, nvenc"):
        Settings(hardware="cuda")
    with pytest.raises(UsageError, match="hardware cannot be combined with split_minutes"):
        Settings(hardware="auto", split_minutes=1)
    assert Settings(hardware="auto").of_videos() == ["hardware"]
