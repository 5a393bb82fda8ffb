"""A region of makeup is two files of its own and a name in the registry: a toy region proves it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import FINISHES, Look, find_faces
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.look.regions import REGIONS
from makeup_video.pipeline.render.regions import PAINTED
from people import SAMPLES

ROOT = Path(__file__).parents[4]
PORTRAIT = SAMPLES / "portrait.jpg"
CHEEKS = 50, 280  # points of the face
HALF = 0.25  # half the side of a cheek, in eye distances

DESCRIPTION = """
from makeup_video.pipeline.look.regions.info import Dial, RegionInfo
from makeup_video.pipeline.look.regions.lips import INFO as LIPS

INFO = RegionInfo(
    name="cheeks", title="Cheeks", product="Blush", part="cheeks", category="blush",
    first_rgb=(200, 80, 90), finishes=LIPS.finishes,
    dials=(Dial("flush", 1.0, "Flush", "How much of the blush.", scales=True),),
)
"""

PAINTER = f"""
from dataclasses import dataclass, replace
from typing import ClassVar

import cv2
import numpy as np
from makeup_video.kernels.surface import GridPlace
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.luminance import broad
from makeup_video.pipeline.render.surfaces.base import lit_in_numpy

SIZE = 16
WEIGHT = np.outer(np.hanning(SIZE + 2)[1:-1], np.hanning(SIZE + 2)[1:-1]).astype(np.float32)


@dataclass(frozen=True)
class Cheek:
    grid: Grid
    normals: ClassVar = np.zeros((2, SIZE, SIZE), np.float32)
    spared: ClassVar = 0.0
    keep_highlights: ClassVar = 1.0

    def reach(self, softness, shape):
        return self.grid.box_px((0, 0, SIZE, SIZE), more=1)

    def weigh(self, out, origin_xy, softness, shape):
        to_px = self.grid.to_px.copy()
        to_px[:, 2] -= origin_xy
        cv2.warpAffine(WEIGHT, to_px, out.shape[::-1], out)

    def shaded(self, luminance):
        (light,), mean = broad(luminance, (WEIGHT > 0.1,), 2.0)
        return light, mean

    def scaled(self, to_new):
        return replace(self, grid=Grid(compose(to_new, self.grid.to_px), self.grid.size_wh))


class Cheeks:
    def places(self, face):
        side = {HALF} * 2 * iod_px(face)
        step = side / (SIZE - 1)
        corners = face.points_px[{list(CHEEKS)}, :2] - side / 2
        maps = [(step, 0.0, x, 0.0, step, y) for x, y in corners.tolist()]
        return [GridPlace(to_px, to_px) for to_px in maps]

    def surfaces(self, seen, places):
        return lit_in_numpy(seen, [Cheek(Grid.at(p.to_px, (SIZE, SIZE))) for p in places])

    def amount(self, face):
        return 1.0

    def shade(self, light, mean):
        return 1.0


REGION = Cheeks()
"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    """Return a function that runs Python with a copy of the product that has a region `cheeks`."""
    home = tmp_path_factory.mktemp("toy")
    package = shutil.copytree(ROOT / "package", home / "makeup_video")
    shutil.copytree(ROOT / "pipeline", package / "pipeline")
    for folder in ("kernels", "web", "cli", "benchmark"):
        (package / folder).symlink_to(ROOT / folder)
    (package / "pipeline" / "look" / "regions" / "cheeks.py").write_text(DESCRIPTION)
    (package / "pipeline" / "render" / "regions" / "cheeks.py").write_text(PAINTER)
    registry = package / "pipeline" / "look" / "regions" / "__init__.py"
    names_line = '_NAMES = ("lips", "eyes")'
    assert registry.read_text().count(names_line) == 1
    registry.write_text(
        registry.read_text().replace(names_line, '_NAMES = ("lips", "eyes", "cheeks")')
    )

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


def test_the_command_paints_a_new_region_and_no_other(toy, tmp_path):
    out, look = tmp_path / "out.png", tmp_path / "look.json"
    arguments = ("--color", "B4002E", "--parts", "cheeks", "-o", out, "--save-look", look)
    done = toy("-m", "makeup_video", PORTRAIT, *arguments)
    assert done.returncode == 0, done.stderr
    before, after = cv2.imread(str(PORTRAIT)), cv2.imread(str(out))
    changed = (before != after).any(2)
    (face,) = find_faces(np.ascontiguousarray(before[..., ::-1]))
    reach = 1.3 * HALF * iod_px(face)
    near = np.zeros_like(changed)
    for x, y in face.points_px[list(CHEEKS), :2].astype(int):
        assert changed[y, x]
        near[int(y - reach) : int(y + reach), int(x - reach) : int(x + reach)] = True
    assert not (changed & ~near).any()
    saved = json.loads(look.read_text())
    assert saved["cheeks"]["red"] == 180 and saved["lips"] is None and saved["flush"] == 1


def test_a_look_file_has_the_new_region_beside_the_old_ones(toy, tmp_path):
    look = Look().to_dict() | {"cheeks": None, "flush": 0.5}
    (tmp_path / "look.json").write_text(json.dumps(look))
    done = toy(
        "-c", f"import makeup_video\nmakeup_video.Look.load({str(tmp_path / 'look.json')!r})"
    )
    assert done.returncode == 0, done.stderr
    (tmp_path / "look.json").write_text(json.dumps(look | {"flush": 2}))
    arguments = ("--look", tmp_path / "look.json", "-o", tmp_path / "out.png")
    done = toy("-m", "makeup_video", PORTRAIT, *arguments)
    assert done.returncode == 2 and "flush must be a number in 0..1, got 2" in done.stderr


def test_messages_name_the_new_region(toy, tmp_path):
    arguments = ("--color", "B02", "--parts", "nose", "-o", tmp_path / "out.png")
    done = toy("-m", "makeup_video", PORTRAIT, *arguments)
    assert "--parts must be lips, eyes, cheeks or lips,eyes,cheeks, got 'nose'" in done.stderr
    assert "cheeks" in toy("-m", "makeup_video", "apply", "--help").stdout


def test_the_page_and_the_finishes_have_the_new_region(toy):
    program = (
        "import json\n"
        "from makeup_video.pipeline import FINISHES, Look\n"
        "from makeup_video.web.messages import hello\n"
        "class Session: name, look, photo = 'a', Look(), None\n"
        "regions = json.loads(hello('live', Session()))['regions']\n"
        "print(json.dumps([[region['name'] for region in regions], list(FINISHES['gloss'])]))"
    )
    done = toy("-c", program)
    assert json.loads(done.stdout) == [["lips", "eyes", "cheeks"]] * 2, done.stderr


def test_every_region_has_a_description_and_a_painter():
    assert list(PAINTED) == list(REGIONS)
    assert all(name == info.name for name, info in REGIONS.items())
    assert all(list(info.finishes) == list(FINISHES) for info in REGIONS.values())
    dials = [dial.name for info in REGIONS.values() for dial in info.dials]
    assert len(set(dials)) == len(dials)
