"""The codec table is complete, loads quickly, and is the only place that names codecs."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from makeup_video.pipeline import UsageError
from makeup_video.pipeline.media.codecs import CODECS, codecs_with, encoder_options, pick_codec
from typer.testing import CliRunner

PIPELINE = Path(__file__).parents[3] / "pipeline"
# These files compare FFmpeg's names for the codecs and formats of inputs.
READ_INPUTS = {
    "media/codecs.py",
    "media/decode.py",
    "media/frame_times.py",
    "media/input_file.py",
    "media/streams.py",
}


def names_in(path):
    """Return the string constants in a file that name a codec or an encoder."""
    known = set(CODECS) | {codec.encoder for codec in CODECS.values()}
    constants = (
        node.value
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    )
    return [text for text in constants if text in known]


def test_no_other_file_knows_a_codec_by_name():
    files = {path.relative_to(PIPELINE).as_posix(): path for path in PIPELINE.rglob("*.py")}
    assert set(files) > READ_INPUTS and names_in(files["media/codecs.py"])
    for name in set(files) - READ_INPUTS:
        assert names_in(files[name]) == [], name


@pytest.mark.parametrize("name", list(CODECS))
def test_a_row_is_complete(name):
    codec = CODECS[name]
    assert codec.name == name and set(codec.transparent_in) <= set(codec.containers)
    if codec.quiet or codec.bottom_first or codec.hdr:
        assert codec.parameters
    for preset in filter(None, (codec.preset, codec.live_preset)):
        assert codec.presets and preset in codec.presets
    if codec.transparent_in:
        assert any(layout.startswith("yuva") for layout in codec.pix_fmts)
    for container in codec.containers:
        assert pick_codec(name, container, deep=False, alpha=False) is codec


@pytest.mark.parametrize(
    ("name", "preset", "known"),
    [("h264", " Very-Fast", "veryfast"), ("av1", "8", "8"), ("av1", "-1", None), ("av1", "1.0", None),
     ("vp9", "-5", None), ("h264", " ", None)],
)  # fmt: skip
def test_a_preset_is_never_another_number(name, preset, known):
    codec = CODECS[name]
    if known:
        assert encoder_options(codec, None, preset) == encoder_options(codec, None, known)
    else:
        with pytest.raises(UsageError, match="preset must be one of"):
            encoder_options(codec, None, preset)


@pytest.mark.parametrize(
    ("word", "name"),
    [("H.264", "h264"), ("x264", "h264"), ("AVC", "h264"), ("h265", "hevc"), ("H.265", "hevc"),
     ("x265", "hevc"), ("HEVC", "hevc"), ("AV1", "av1"), ("svt-av1", "av1"), ("VP9", "vp9"),
     ("ProRes", "prores"), ("FFV1", "ffv1")],
)  # fmt: skip
def test_codecs_are_known_by_their_usual_names(word, name):
    container = CODECS[name].containers[0]
    assert pick_codec(word, container, deep=False, alpha=False) is CODECS[name]


def test_no_word_means_two_codecs():
    words = [word for codec in CODECS.values() for word in (codec.name, *codec.also)]
    assert len({word.replace("-", "").replace("_", "") for word in words}) == len(words)


@pytest.mark.parametrize(
    ("word", "message"),
    [("hecv", "must be one of h264, .* got 'hecv': did you mean hevc?"), ("", "got ''$"),
     ("mpeg2", "got 'mpeg2'$")],
)  # fmt: skip
def test_an_unknown_codec_is_refused_with_the_nearest(word, message):
    with pytest.raises(UsageError, match=message):
        pick_codec(word, "mp4", deep=False, alpha=False)


def test_the_table_loads_no_large_library():
    code = (
        "import sys; import makeup_video.pipeline.media.codecs\n"
        "print(sorted({'av', 'numpy', 'cv2', 'PIL'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_lists_every_codec():
    from makeup_video.cli.app import app

    output = CliRunner().invoke(app, ["apply", "--help"], env={"COLUMNS": "200"}).output
    assert codecs_with(lambda codec: True) in " ".join(output.split())
