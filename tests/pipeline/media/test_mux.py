"""Everything but the painted video: audio, subtitles, data, chapters, cover art, tags."""

import random
from contextlib import closing
from fractions import Fraction

import av
import pytest
from av.stream import Disposition
from makeup_video.pipeline import Look, Settings, StrictError, process_looks, process_video
from makeup_video.pipeline.files.output_file import OutputFile
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.transcode import SubtitleConverter
from media import add_video, decoded, encode_frames, make_clip, packets_of
from rich_clips import (
    TITLES,
    add_titles,
    chapters_of,
    klv_clip,
    make_cover,
    rich_clip,
    titles_of,
    write_title,
    write_titles,
)


def run(src, dst, **settings):
    return process_video(src, dst, None, Settings(**settings))


@pytest.mark.parametrize("start", [".mp4", ".mov", ".mkv"])
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_audio_packets_are_bit_identical_and_in_time(tmp_path, start, end):
    src, dst = rich_clip(tmp_path / f"in{start}"), tmp_path / f"out{end}"
    report = run(src, dst)
    is_unsaid = end == ".mov" and start != ".mov"
    assert report.converted == []
    assert report.dropped == ["audio #2 (aac): mov cannot mark it as comment"] * is_unsaid
    for index in range(2):
        old, new = packets_of(src, "audio", index), packets_of(dst, "audio", index)
        assert [data for _, data in old] == [data for _, data in new]
        for (a, _), (b, _) in zip(old, new, strict=True):
            assert abs(a - b) <= Fraction(1, 1000)
            assert a == b or ".mkv" in (start, end)


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_languages_dispositions_titles_and_chapters_are_kept(tmp_path, end):
    src, dst = rich_clip(tmp_path / "in.mp4", titles="mov_text"), tmp_path / f"out{end}"
    run(src, dst)
    with av.open(str(dst)) as container:
        assert [s.metadata.get("language") for s in container.streams.audio] == ["eng", "deu"] or [
            s.metadata.get("language") for s in container.streams.audio
        ] == ["eng", "ger"]
        assert container.streams.subtitles[0].metadata["language"] in ("fre", "fra")
        tags = {key.lower(): value for key, value in container.metadata.items()}
        assert (tags["title"], tags["artist"]) == ("A video", "Somebody")
        assert container.streams.audio[0].disposition & Disposition.default
        if end == ".mkv":
            assert container.streams.audio[1].disposition & Disposition.comment
    assert chapters_of(dst) == chapters_of(src) != []


@pytest.mark.parametrize("end", [".mp4", ".mov"])
def test_the_timecode_stream_is_kept(tmp_path, end):
    src, dst = rich_clip(tmp_path / "in.mov"), tmp_path / f"out{end}"
    report = run(src, dst)
    assert report.dropped == []
    with av.open(str(dst)) as container:
        streams = [s for s in container.streams if s.type == "data" and "timecode" in s.metadata]
        assert [s.metadata["timecode"] for s in streams] == ["01:02:03:04"]
    assert packets_of(src, "data", 1) == packets_of(dst, "data", 1)


def test_timecode_survives_matroska_and_comes_back(tmp_path):
    run(rich_clip(tmp_path / "in.mov"), tmp_path / "out.mkv")
    run(tmp_path / "out.mkv", tmp_path / "again.mov")
    with av.open(str(tmp_path / "again.mov")) as container:
        assert container.streams.video[0].metadata["timecode"] == "01:02:03:04"


@pytest.mark.parametrize(
    ("start", "codec"),
    [(".mp4", "mov_text"), (".mkv", "subrip"), (".mkv", "ass"), (".webm", "webvtt")],
)
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_subtitles_arrive_with_their_words_and_times(tmp_path, start, codec, end):
    src = tmp_path / f"in{start}"
    with av.open(str(src), "w") as out:
        video = add_video(out, "vp9" if start == ".webm" else "h264")
        text = add_titles(out, codec)
        encode_frames(out, video, range(30))
        write_titles(out, text)
    report = run(src, tmp_path / f"out{end}")
    assert report.dropped == []
    got = titles_of(tmp_path / f"out{end}")
    want = [(a, b, text) for a, b, text in TITLES]
    assert [(a, b) for a, b, _ in got] == [(a, b) for a, b, _ in want]
    assert [text.strip() for _, _, text in got] == [text for _, _, text in want]


@pytest.mark.parametrize("end", [".mp4", ".mov"])
@pytest.mark.parametrize("codec", ["subrip", "ass"])
def test_subtitles_that_overlap_are_shown_below_one_another(tmp_path, codec, end):
    src, dst = tmp_path / "in.mkv", tmp_path / f"out{end}"
    with av.open(str(src), "w") as out:
        video, text = add_video(out), add_titles(out, codec)
        encode_frames(out, video, range(30))
        write_title(out, text, 100, 600, b"first")
        write_title(out, text, 300, 200, b"second")
        write_title(out, text, 800, 100, b"third")
    run(src, dst)
    assert titles_of(dst) == [
        (100, 200, b"first"),
        (300, 200, b"first\nsecond"),
        (500, 200, b"first"),
        (800, 100, b"third"),
    ]


def test_a_subtitle_without_a_time_does_not_end_the_run(tmp_path):
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        video, text = add_video(out), add_titles(out, "subrip")
        encode_frames(out, video, range(3))
        write_title(out, text, 0, 100, b"first")
    with av.open(str(src)) as container, av.open(str(tmp_path / "out.mp4"), "w") as out:
        stream = container.streams.subtitles[0]
        convert = SubtitleConverter(out, "mov_text", av.CodecContext.create("subrip", "r"))
        packet = next(container.demux(stream))
        packet.pts = packet.dts = None
        (converted,) = convert(packet)
        assert converted.pts is None and b"first" in bytes(converted)
        assert convert.flush() == []


def test_aac_into_webm_becomes_opus_and_stays_in_sync(tmp_path):
    src, dst = make_clip(tmp_path / "in.mp4", frames=60, audio="aac"), tmp_path / "out.webm"
    report = run(src, dst)
    assert report.converted == ["audio #1 (aac) -> libopus"]
    with av.open(str(dst)) as container:
        frames = list(container.decode(audio=0))
        assert container.streams.audio[0].codec_context.name in ("opus", "libopus")
        first = frames[0].pts * frames[0].time_base
        last = frames[-1].pts * frames[-1].time_base + Fraction(frames[-1].samples, 48000)
    assert abs(first) < Fraction(1, 100)
    assert abs(last - 2) < Fraction(1, 20)


@pytest.mark.parametrize(
    ("codec", "end"),
    [
        ("libopus", ".webm"),
        ("libopus", ".mp4"),
        ("flac", ".mp4"),
        ("ac3", ".mov"),
        ("libmp3lame", ".mp4"),
        ("pcm_s16le", ".mov"),
        ("pcm_s16le", ".mp4"),
    ],
)
def test_audio_that_the_container_holds_is_not_converted(tmp_path, codec, end):
    src = make_clip(tmp_path / "in.mkv", audio=codec)
    report = run(src, tmp_path / f"out{end}")
    assert report.converted == []
    old, new = packets_of(src, "audio"), packets_of(tmp_path / f"out{end}", "audio")
    assert b"".join(data for _, data in old) == b"".join(data for _, data in new)


@pytest.mark.parametrize("end", [".mp4", ".mkv"])
def test_cover_art_is_kept_and_never_taken_for_the_video(tmp_path, end):
    src, dst = tmp_path / "in.mp4", tmp_path / f"out{end}"
    cover = make_cover(src)
    report = run(src, dst)
    assert report.dropped == []
    assert report.frames_in == 10
    with av.open(str(dst)) as container:
        covers = [s for s in container.streams.video if s.disposition & Disposition.attached_pic]
        assert len(covers) == 1
        packets = [bytes(p) for p in container.demux(covers[0]) if p.size]
    assert packets == [cover]
    assert (decoded(dst)[0].width, len(decoded(dst))) == (96, 10)


@pytest.mark.parametrize("end", [".mov", ".webm"])
def test_cover_art_that_does_not_fit_is_dropped_by_name(tmp_path, end):
    src = tmp_path / "in.mp4"
    make_cover(src)
    report = run(src, tmp_path / f"out{end}")
    assert len(report.dropped) == 1 and "mjpeg" in report.dropped[0]


@pytest.mark.parametrize("end", [".mkv", ".mp4", ".webm"])
def test_attachments_stay_in_matroska_or_are_named(tmp_path, end):
    src, dst = tmp_path / "in.mkv", tmp_path / f"out{end}"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        out.add_attachment("font.ttf", "font/ttf", b"not really a font" * 10)
        encode_frames(out, video, range(5))
    report = run(src, dst)
    with av.open(str(dst)) as container:
        kept = [(s.metadata.get("filename"), s.data) for s in container.streams.attachments]
    if end == ".mkv":
        assert kept == [("font.ttf", b"not really a font" * 10)]
        assert report.dropped == []
    else:
        assert kept == []
        assert len(report.dropped) == 1 and "attachment" in report.dropped[0]


def test_an_audio_stream_of_unknown_format_is_dropped(tmp_path):
    """Broadcasts announce streams that never carry a packet."""
    src = tmp_path / "in.ts"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        out.add_stream("aac", rate=48000, layout="stereo")
        encode_frames(out, video, range(30))
    for end in (".mp4", ".mkv", ".webm"):
        report = run(src, tmp_path / f"out{end}")
        assert report.frames_out == 30
        with av.open(str(tmp_path / f"out{end}")) as container:
            kept = len(container.streams.audio)
        assert kept + len(report.dropped) == 1


@pytest.mark.parametrize("end", [".mp4", ".mkv", ".webm"])
def test_a_damaged_packet_of_another_stream_is_counted(tmp_path, end):
    clip = make_clip(tmp_path / "whole.ts", frames=60, audio="aac", options={"g": "10"})
    skipped = 0
    for seed in range(8):
        data, rng = bytearray(clip.read_bytes()), random.Random(seed)
        for _ in range(40):
            data[rng.randrange(len(data) // 5, len(data))] ^= 0xFF
        src = tmp_path / f"in{seed}.ts"
        src.write_bytes(data)
        report = run(src, tmp_path / f"out{seed}{end}")
        assert report.frames_out == len(decoded(tmp_path / f"out{seed}{end}")) > 20
        skipped += report.skipped_packets
        if report.skipped_packets:
            assert report.damaged
    assert skipped > 0 or end != ".mp4"


def test_a_data_stream_is_dropped_by_name_or_refused(tmp_path):
    src = klv_clip(tmp_path / "in.ts")
    report = run(src, tmp_path / "out.mp4")
    assert report.dropped == ["data #1 (klv): mp4 cannot hold it"]
    with pytest.raises(StrictError, match="klv"):
        run(src, tmp_path / "strict.mp4", strict=True)
    assert not list(tmp_path.glob("strict*"))


@pytest.mark.parametrize("end", [".mkv", ".mp4"])
def test_mkv_is_not_advised_for_what_a_codec_loses(tmp_path, end):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuva420p")
    with pytest.raises(StrictError, match=r"transparency: .*\. Leave strict out\.$"):
        run(src, tmp_path / f"out{end}", codec="h264", bit_depth=8, strict=True)


def test_mkv_is_advised_for_what_another_container_loses(tmp_path):
    src = klv_clip(tmp_path / "in.ts")
    with pytest.raises(StrictError, match=r"klv.*\. Use \.mkv, or leave strict out\.$"):
        run(src, tmp_path / "out.mp4", strict=True)


def test_tags_beyond_the_common_ones_are_kept(tmp_path):
    src = tmp_path / "in.mov"
    with av.open(str(src), "w", container_options={"movflags": "use_metadata_tags"}) as out:
        video = add_video(out)
        out.metadata.update({"com.apple.quicktime.model": "Phone 9", "title": "A video"})
        encode_frames(out, video, range(5))
    run(src, tmp_path / "out.mov")
    with av.open(str(tmp_path / "out.mov")) as container:
        assert container.metadata["com.apple.quicktime.model"] == "Phone 9"
        assert container.metadata["title"] == "A video"


def test_mp4_is_ready_to_stream(tmp_path):
    run(make_clip(tmp_path / "in.mp4", audio="aac"), tmp_path / "out.mp4")
    data = (tmp_path / "out.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")


def test_trimmed_chapters_and_subtitles_move_with_the_picture(tmp_path):
    src, dst = rich_clip(tmp_path / "in.mkv", titles="subrip"), tmp_path / "out.mkv"
    run(src, dst, start_seconds=Fraction(1, 5))
    assert chapters_of(dst) == [
        (0, Fraction(3, 10), "One"),
        (Fraction(3, 10), Fraction(4, 5), "Two"),
    ]
    assert [(a, b) for a, b, _ in titles_of(dst)] == [(0, 300), (300, 300)]


def test_packets_before_the_header_are_not_lost(tmp_path):
    """Audio before the first frame waits in memory and is then written whole."""
    src = make_clip(
        tmp_path / "in.mkv", audio="aac", pts=[3000 + 33 * i for i in range(10)],
        time_base=Fraction(1, 1000),
    )  # fmt: skip
    run(src, tmp_path / "out.mkv")
    assert packets_of(src, "audio") == packets_of(tmp_path / "out.mkv", "audio")


def test_an_aborted_output_leaves_nothing(tmp_path):
    source = make_clip(tmp_path / "in.mp4")
    muxer = Muxer(OutputFile(tmp_path / "out.mp4", source, overwrite=False), "mp4")
    assert (tmp_path / "out.part.mp4").exists()
    muxer.abort()
    assert list(tmp_path.iterdir()) == [source]


def test_a_packet_for_an_aborted_output_is_an_error(tmp_path):
    """FFmpeg would end the process."""
    path = make_clip(tmp_path / "in.mp4")
    muxer = Muxer(OutputFile(tmp_path / "out.mkv", path, overwrite=False), "matroska")
    with closing(open_video(path)) as source:
        muxer.open(source, lambda out: out.add_stream_from_template(source.video))
        muxer.start()
        packet = next(source.container.demux(source.video))
        muxer.abort()
        with pytest.raises(AttributeError):
            muxer.write(packet)


@pytest.mark.parametrize("end", [".mp4", ".mkv", ".webm"])
def test_sound_that_an_edit_list_hides_stays_hidden(tmp_path, end):
    """A phone cuts away the first second of a video: its packets remain, with times before 0."""
    whole, src = make_clip(tmp_path / "whole.mp4", frames=90, audio="aac"), tmp_path / "in.mp4"
    with av.open(str(whole)) as container, av.open(str(src), "w") as out:
        streams = [out.add_stream_from_template(each, opaque=True) for each in container.streams]
        for packet in container.demux():
            if packet.size:
                packet.pts -= round(1 / packet.time_base)
                packet.dts -= round(1 / packet.time_base)
                packet.stream = streams[packet.stream.index]
                out.mux(packet)
    dst, many = tmp_path / f"out{end}", [tmp_path / f"{name}{end}" for name in "ab"]
    process_video(src, dst)
    process_looks(src, dict.fromkeys(many, Look()))
    for path in (dst, *many):
        with av.open(str(path)) as container:
            first = next(container.decode(audio=0))
        assert float(first.pts * first.time_base) > -0.05
