"""The checks find every difference between an output and its report."""

import av
import pytest
from fuzz.check import video_faults
from fuzz.videos import VIDEOS
from makeup_video.pipeline import process_video
from media import make_clip


@pytest.fixture
def painted(tmp_path):
    """(source, output, report as a dict) of a correct run."""
    source, output = tmp_path / "in.mkv", tmp_path / "out.mkv"
    VIDEOS["ass_font.mkv"].write(source)
    return source, output, process_video(source, output).to_dict()


def rewrite(path, change):
    """Rewrite a file with every packet passed through `change`; None drops the packet."""
    packets, new = [], path.with_name("new.mkv")
    with av.open(str(path)) as old, av.open(str(new), "w") as out:
        streams = {s.index: s for s in old.streams if s.type != "attachment"}
        streams = {i: out.add_stream_from_template(s, opaque=True) for i, s in streams.items()}
        for packet in old.demux():
            if packet.size and (changed := change(packet)) is not None:
                changed.stream = streams[packet.stream.index]
                packets.append(changed)
        for packet in packets:
            out.mux_one(packet)
    new.replace(path)


def other(packet):
    changed = av.Packet(bytes(len(bytes(packet))))
    changed.pts, changed.dts, changed.time_base = packet.pts, packet.dts, packet.time_base
    return changed


def nth(kind, change, number=2):
    """Applies `change` to packet `number` of one kind of stream."""
    seen = []

    def once(packet):
        seen.extend([1] if packet.stream.type == kind else [])
        hit = packet.stream.type == kind and len(seen) == number
        return change(packet) if hit else packet

    return once


def test_a_true_report_has_no_faults(painted):
    assert video_faults(*painted, trimmed=False) == []


@pytest.mark.parametrize("name", sorted(VIDEOS))
@pytest.mark.parametrize("end", [".mp4", ".mkv"])
def test_no_whole_video_is_called_broken(tmp_path, name, end):
    source, output = tmp_path / name, tmp_path / f"out{end}"
    VIDEOS[name].write(source)
    try:
        report = process_video(source, output)
    except OSError as error:  # a fault of the product, which `--as-is` reports
        pytest.skip(str(error))
    assert video_faults(source, output, report.to_dict(), trimmed=False) == []


def test_a_wrong_number_of_frames_is_found(painted):
    source, output, report = painted
    faults = video_faults(source, output, {**report, "frames_out": 11}, trimmed=False)
    assert "11 frames reported, 10 packets in the output" in faults


def test_a_lost_frame_is_found(painted):
    source, output, report = painted
    rewrite(output, nth("video", lambda packet: None))
    assert "10 frames reported, 9 packets in the output" in video_faults(
        source, output, report, trimmed=False
    )


def test_sound_that_differs_is_found(painted):
    source, output, report = painted
    rewrite(output, nth("audio", other))
    assert video_faults(source, output, report, trimmed=False) == [
        "audio #1 (mp3float): other packets than in the input"
    ]


def test_sound_that_is_lost_is_found_unless_it_is_reported(painted):
    source, output, report = painted
    rewrite(output, nth("audio", lambda packet: None))
    assert video_faults(source, output, report, trimmed=False) == [
        "1 packets of copied streams are missing, 0 reported"
    ]
    assert video_faults(source, output, {**report, "skipped_packets": 1}, trimmed=False) == []
    assert video_faults(source, output, report, trimmed=True) == []


def test_subtitles_that_differ_are_found(painted):
    source, output, report = painted
    rewrite(output, nth("subtitle", other))
    (fault,) = video_faults(source, output, report, trimmed=False)
    assert fault.startswith("subtitle #2")


@pytest.mark.parametrize("kind", ["audio", "subtitle"])
def test_a_missing_stream_is_found_unless_reported(painted, tmp_path, kind):
    source, _, report = painted
    index = {"audio": 1, "subtitle": 2}[kind]
    bare = make_clip(tmp_path / "bare.mkv", frames=10, audio=None if kind == "audio" else "mp2")
    faults = video_faults(source, bare, report, trimmed=False)
    assert f"{kind} streams: 1 promised, 0 in the output" in faults
    reported = {**report, "dropped": [f"{kind} #{index} (x): no room"]}
    assert not any(kind in fault for fault in video_faults(source, bare, reported, trimmed=False))


def test_an_output_that_is_no_video_is_found(painted):
    source, output, report = painted
    output.write_bytes(b"nothing")
    (fault,) = video_faults(source, output, report, trimmed=False)
    assert fault.startswith("the output does not open")
