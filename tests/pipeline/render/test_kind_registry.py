"""A kind of makeup is one file and a word in the registry: a toy kind proves it."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import FINISHES, Look, find_faces
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.look.kinds import KINDS, PARTS
from makeup_video.pipeline.render.regions import REGIONS
from people import SAMPLES

ROOT = Path(__file__).parents[3]
PORTRAIT = SAMPLES / "portrait.jpg"
CHEEKS = 50, 280  # points of the face

FRECKLES = '''
"""Freckles: dots in rows on both cheeks."""

from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.look.kinds.kind import Coat, Dial, Kind
from makeup_video.pipeline.look.kinds.lipstick import KIND as LIPSTICK


def _coats(at: FaceFields, product, shape):
    import numpy as np

    on_cheeks = (np.abs(np.abs(at.across) - 0.33) < 0.16) & (np.abs(at.down - 0.3) < 0.12)
    wave = np.sin(60 * at.across) * np.sin(60 * at.down)
    dots = shape["amount"] * np.clip(2 * wave, 0, 1) * on_cheeks
    return [Coat(product, dots.astype(np.float32))]


KIND = Kind(
    name="freckles", part="freckles", title="Freckles", product="Freckle pen", must_see="cheeks",
    category="freckle", first_rgb=(120, 70, 50), first_finish="matte",
    finishes=LIPSTICK.finishes, is_read=False, order=15, region="face", coats=_coats, most=2,
    dials=(
        Dial("amount", 1.0, "Amount", "How many there are."),
        Dial("tone", "warm", "Tone", "Their tone.", choices=("warm", "cool")),
    ),
)
'''


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    """Return a function that runs Python with a copy of the product that has a kind `freckles`."""
    home = tmp_path_factory.mktemp("toy")
    package = shutil.copytree(ROOT / "package", home / "makeup_video")
    shutil.copytree(ROOT / "pipeline", package / "pipeline")
    for folder in ("kernels", "web", "cli", "benchmark"):
        (package / folder).symlink_to(ROOT / folder)
    kinds = package / "pipeline" / "look" / "kinds"
    (kinds / "freckles.py").write_text(FRECKLES)
    registry = (kinds / "__init__.py").read_text()
    longer, count = re.subn(r'_NAMES = \(([^)]*")', r'_NAMES = (\1, "freckles"', registry)
    assert count == 1
    (kinds / "__init__.py").write_text(longer)

    def run(*arguments):
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            cwd=home,
            env={**os.environ, "PYTHONPATH": str(home)},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def painted_on(path):
    """Return where a picture differs from the portrait, and the portrait's face."""
    before, after = cv2.imread(str(PORTRAIT)), cv2.imread(str(path))
    (face,) = find_faces(np.ascontiguousarray(before[..., ::-1]))
    return (before != after).any(2), face


@pytest.mark.parametrize(
    "arguments",
    [("--color", "B4002E", "--parts", "freckles"), ("--freckles", "B4002E:satin")],
    ids=["parts", "option"],
)
def test_the_command_paints_a_new_kind_and_no_other(toy, tmp_path, arguments):
    out, saved = tmp_path / "out.png", tmp_path / "look.json"
    done = toy("-m", "makeup_video", PORTRAIT, *arguments, "-o", out, "--save-look", saved)
    assert done.returncode == 0, done.stderr
    changed, face = painted_on(out)
    near, reach = np.zeros_like(changed), int(0.42 * iod_px(face))
    for x, y in face.points_px[list(CHEEKS), :2].astype(int):
        near[y - reach : y + reach, x - reach : x + reach] = True
        assert (
            changed[y - reach // 4 : y + reach // 4, x - reach // 4 : x + reach // 4].mean() > 0.1
        )
    assert not (changed & ~near).any()
    (layer,) = json.loads(saved.read_text())["layers"]
    assert layer["kind"] == "freckles" and layer["product"]["red"] == 180


def test_a_look_file_has_the_new_kind_beside_the_old_ones(toy, tmp_path):
    path, product = tmp_path / "look.json", PRODUCT
    layers = [
        {"kind": "lipstick", "product": product},
        {"kind": "freckles", "product": product, "shape": {"amount": 0.5}, "strength": 0.7},
        {"kind": "freckles", "product": product, "shape": {"tone": "cool"}},
        {"kind": "blush", "product": product},
    ]
    path.write_text(json.dumps({"version": 2, "layers": layers}))
    program = (
        "import json\n"
        "from makeup_video import Look\n"
        "from makeup_video.pipeline.look.finishes import look_in_words\n"
        f"look = Look.load({str(path)!r})\n"
        "print(json.dumps([[layer.kind for layer in look.layers], look_in_words(look)]))"
    )
    done = toy("-c", program)
    assert done.returncode == 0, done.stderr
    kinds, words = json.loads(done.stdout)
    assert kinds == ["blush", "freckles", "freckles", "lipstick"]  # in the order of painting
    assert "freckles #B4002E" in words
    out = tmp_path / "out.png"
    done = toy("-m", "makeup_video", PORTRAIT, "--look", path, "-o", out)
    assert done.returncode == 0, done.stderr
    changed, face = painted_on(out)
    for point in (*CHEEKS, 17):  # cheeks, and the lower lip
        x, y = face.points_px[point, :2].astype(int)
        assert changed[y - 12 : y + 12, x - 12 : x + 12].mean() > 0.1


PRODUCT = {"red": 180, "green": 0, "blue": 46, "opacity": 0.9, "gloss": 0, "gloss_roughness": 0.5,
           "reflection": 0}  # fmt: skip


@pytest.mark.parametrize(
    "layers, message",
    [
        ([{"shape": {"amount": 2}}], "layers[0].shape.amount must be a number in 0..1, got 2"),
        ([{}, {"shape": {"tone": "red"}}],
         'layers[1].shape.tone must be one of warm, cool, got "red"'),
        ([{}, {}, {}], "a look has at most 2 layers of freckles, got 3"),
        ([{"kind": "wart"}],
         f"layers[0].kind must be one of {', '.join([*KINDS, 'freckles'])}, got"),
    ],
)  # fmt: skip
def test_messages_about_look_files_name_the_new_kind(toy, tmp_path, layers, message):
    path = tmp_path / "look.json"
    whole = [{"kind": "freckles", "product": PRODUCT} | layer for layer in layers]
    path.write_text(json.dumps({"version": 2, "layers": whole}))
    done = toy("-m", "makeup_video", PORTRAIT, "--look", path, "-o", tmp_path / "out.png")
    assert done.returncode == 2 and message in done.stderr, done.stderr


def test_messages_and_help_of_the_command_name_the_new_part(toy, tmp_path):
    arguments = ("--color", "B02", "--parts", "nose", "-o", tmp_path / "out.png")
    done = toy("-m", "makeup_video", PORTRAIT, *arguments)
    assert done.returncode == 2 and ", ".join([*PARTS, "freckles"]) in done.stderr
    helped = toy("-m", "makeup_video", "apply", "--help").stdout
    assert "--freckles" in helped and "Freckle pen" in helped


def test_the_page_and_the_finishes_have_the_new_kind(toy):
    program = (
        "import json\n"
        "from makeup_video.pipeline import FINISHES, Look\n"
        "from makeup_video.web.messages import hello\n"
        "class Session: name, look, photo, has_video = 'a', Look(), None, False\n"
        "kinds = json.loads(hello('live', Session()))['kinds']\n"
        "print(json.dumps([kinds, list(FINISHES['gloss'])]))"
    )
    done = toy("-c", program)
    assert done.returncode == 0, done.stderr
    kinds, parts = json.loads(done.stdout)
    assert [kind["name"] for kind in kinds] == [*KINDS, "freckles"]
    assert parts == [*PARTS, "freckles"]
    freckles = kinds[-1]
    assert (freckles["title"], freckles["most"], freckles["first_finish"]) == (
        "Freckles",
        2,
        "matte",
    )
    assert [dial["name"] for dial in freckles["dials"]] == ["amount", "tone"]


def test_a_photo_is_read_as_before(toy, tmp_path):
    """The new kind is not read from photos."""
    ours = subprocess.run(
        [sys.executable, "-m", "makeup_video", "estimate", str(SAMPLES / "look.jpg"), "--json"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    done = toy("-m", "makeup_video", "estimate", SAMPLES / "look.jpg", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == json.loads(ours.stdout)


def test_every_kind_of_the_registry_is_whole():
    assert all(name == kind.name for name, kind in KINDS.items())
    assert len(PARTS) == len(KINDS) == len({kind.order for kind in KINDS.values()})
    for kind in KINDS.values():
        assert kind.region in REGIONS and list(kind.finishes) == list(FINISHES)
        assert kind.first_finish in FINISHES and kind.most >= 1
        dials = {dial.name: dial for dial in kind.dials}
        assert len(dials) == len(kind.dials)
        for dial in kind.dials:
            dial.check(dial.default, dial.name)
            assert dial.title and dial.meaning.endswith(".")
        for slot, shape in kind.slots.items():
            assert slot in dials["slot"].choices
            kind.check_shape(shape, slot)
    assert Look().to_dict()["layers"] == []
