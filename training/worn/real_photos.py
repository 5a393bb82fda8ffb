"""Measures how well looks are read from real photographs, and writes that section of the docs.

    python -m makeup_video.training.worn.real_photos --labelled DIR --looks DIR... --bare DIR \
        --page docs/results.md --sheets DIR

labelled: a folder of pictures with worn.csv, as worn/prepare.py describes it. looks: folders of
people with makeup. bare: a folder of people without makeup. page: the file that has the section,
between two markers. sheets: a folder for pictures of every photo beside three bare faces that wear
its look.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.reference.checks import faces_within
from makeup_video.pipeline.reference.estimate import Estimate, estimate
from makeup_video.pipeline.reference.read_makeup import WORN_FROM
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.inputs import existing
from makeup_video.training.worn.prepare import LABELS, UNUSABLE
from makeup_video.training.worn.scores import area_under_curve
from makeup_video.training.worn.table import has_table, labelled_rows, photos_of
from makeup_video.training.worn.zones import EYES, ZONES, Seen, Transfer, see

BEGIN, END = "<!-- real photographs -->", "<!-- end of real photographs -->"
_LONGEST_PX = 700  # photos with a longer side are scaled down to it
_SHEET_PX = 300  # side of each picture on a sheet
_BINS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)  # of the probabilities
_ALARMS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3)  # rates at which the page gives the ROC curves


@dataclass
class Worn:
    """The probabilities read for one kind, on faces labelled as bare and as clearly wearing it."""

    bare: list[float] = field(default_factory=list)
    clear: list[float] = field(default_factory=list)

    def shares(self, threshold: float) -> tuple[float, float]:
        """The shares of bare and of clear faces that are read as wearing the kind."""
        bare, clear = (np.array(each) >= threshold for each in (self.bare, self.clear))
        return float(bare.mean()), float(clear.mean()) if len(clear) else float("nan")

    def area(self) -> float:
        scores = np.array(self.bare + self.clear)
        return area_under_curve(scores, np.arange(len(scores)) >= len(self.bare))

    def alarms_at(self, found: float) -> float:
        """The share of bare faces read as worn when this share of clear ones is found."""
        return float((np.array(self.bare) >= np.quantile(self.clear, 1 - found)).mean())

    def found_at(self, alarms: float) -> float:
        """The share of clear faces that is found when this share of bare ones is read as worn."""
        return float((np.array(self.clear) >= np.quantile(self.bare, 1 - alarms)).mean())


def read(path: Path) -> np.ndarray:
    bgr = cv2.imread(str(path))
    scale = _LONGEST_PX / max(bgr.shape[:2])
    if scale < 1:
        bgr = cv2.resize(bgr, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(bgr[..., ::-1])


def estimated(paths: list[Path]) -> Iterator[tuple[Path, Seen, Estimate]]:
    """The photos whose largest face can be read, each with its estimate; refusals are printed."""
    for path in paths:
        rgb8 = read(path)
        faces = faces_within(rgb8)
        try:
            if faces:
                yield path, see(rgb8, faces[0]), estimate(rgb8, faces[0])
        except PhotoError as error:
            print(f"{path.name}: {error}")


def labelled_layers(
    table: Path, folders: list[Path], kind: str
) -> list[tuple[dict[str, str], Seen, Layer]]:
    """The layers of a kind that are read in the photos that a table names, each with the photo and
    its row of the table. Raises SystemExit if there is no such layer."""
    labels = photos_of(table, folders)
    found = [
        (labels[path], photo, layer)
        for path, photo, one in estimated(list(labels))
        for layer in one.look.of(kind)
    ]
    if not found:
        raise SystemExit(f"--looks: no {kind} is read in photos of {table.name} in these folders")
    return found


def labels_of(folder: Path) -> dict[str, dict[str, str]]:
    """The rows of worn.csv by name; unusable photos are left out."""
    return {row["name"]: row for row in labelled_rows(folder) if not set(row["flags"]) & UNUSABLE}


def worn_of(folder: Path, step: int = 1) -> dict[str, Worn]:
    """The probabilities for each column of worn.csv, from every step-th photo of a folder.

    A folder without worn.csv counts as bare.
    """
    found = {name: Worn() for name in LABELS}
    if has_table(folder):
        rows = labels_of(folder)
    else:
        rows = {path.name: dict.fromkeys(LABELS, "0") for path in sorted(folder.glob("*.jpg"))}
    for path, _, one in estimated([folder / name for name in list(rows)[::step]]):
        for name, kind in LABELS.items():
            values = {"0": found[name].bare, "2": found[name].clear}
            values.get(rows[path.name][name].strip(), []).append(one.worn[kind])
    return found


def transfer_of(looks: list[Path], bare: list[Path], sheets: Path | None) -> Transfer:
    """The zone measure over all photos. A sheet of each photo is written to `sheets`."""
    pictures = [(path, read(path)) for path in bare]
    faces = [see(rgb8, found[0]) for _, rgb8 in pictures if (found := find_faces(rgb8))]
    transfer, painter = Transfer(faces), PaintPictures()

    def paint(canvas: Seen, look: Look) -> np.ndarray:
        return painter(canvas.rgb8, look, [canvas.face])

    for path, photo, one in estimated(looks):
        transfer.add(photo, one.look, paint)
        if sheets is not None:
            made = [paint(canvas, one.look) for canvas in transfer.canvases[:3]]
            row = np.hstack([_square(picture) for picture in (photo.rgb8, *made)])
            cv2.imwrite(str(sheets / f"{path.parent.name}_{path.stem}.jpg"), row[..., ::-1])
    return transfer


def _square(rgb8: np.ndarray) -> np.ndarray:
    scale = _SHEET_PX / max(rgb8.shape[:2])
    small = cv2.resize(rgb8, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    high, wide = small.shape[:2]
    return cv2.copyMakeBorder(
        small, 0, _SHEET_PX - high, 0, _SHEET_PX - wide, cv2.BORDER_CONSTANT, value=(40, 40, 40)
    )


def section(
    labelled: dict[str, Worn],
    plain: dict[str, Worn],
    made_up: list[dict[str, Worn]],
    transfer: Transfer,
) -> str:
    """The section as Markdown, down to the end of its tables.

    made_up: further labelled faces, which count only in the ROC curves and in the reliability of
    the probabilities.
    """
    rows = []
    for name, kind in LABELS.items():
        one, threshold = labelled[name], WORN_FROM[kind]
        bare, clear = one.shares(threshold)
        others = plain[name].shares(threshold)[0]
        alarms = _percent(one.alarms_at(0.9)) if len(one.clear) > 1 else "too few"
        rows.append([
            kind, f"{len(one.bare)}", _percent(bare), f"{len(one.clear)}", _percent(clear),
            _percent(others), f"{one.area():.3f}", alarms,
        ])  # fmt: skip
    head = ["kind", "bare", "read as worn", "clear", "read as worn", "other bare faces",
            "area under ROC", "false alarms at 90 % found"]  # fmt: skip
    zones = [
        [
            zone,
            f"{transfer.photos[zone]}",
            f"{transfer.score(zone):.2f}",
            f"{transfer.best(zone):.2f}",
        ]
        for zone in ZONES
    ] + [["all of the eyes", "", f"{transfer.score(*EYES):.2f}", f"{transfer.best(*EYES):.2f}"]]
    everyone = {
        name: Worn(
            [share for one in (labelled, plain, *made_up) for share in one[name].bare],
            [share for one in (labelled, plain, *made_up) for share in one[name].clear],
        )
        for name in LABELS
    }
    roc = [
        [kind, *(_percent(everyone[name].found_at(alarms)) for alarms in _ALARMS)]
        for name, kind in LABELS.items()
    ]
    curves = [
        [
            kind,
            *(_reliability(everyone[name], low, high) for low, high in pairwise(_BINS)),
        ]
        for name, kind in LABELS.items()
    ]
    bins = [f"{_percent(low)} to {_percent(high)}" for low, high in pairwise(_BINS)]
    return _PAGE.format(
        worn=_table(head, rows),
        zones=_table(["zone", "photos", "comes across", "a perfect transfer"], zones),
        roc=_table(["kind", *(_percent(alarms) for alarms in _ALARMS)], roc),
        curves=_table(["kind", *bins], curves),
    )


def _reliability(one: Worn, low: float, high: float) -> str:
    """The share of the faces with a probability in the bin that wear the kind, and their number."""
    bare, clear = (
        int(((np.array(each) >= low) & (np.array(each) < high + (high == 1))).sum())
        for each in (one.bare, one.clear)
    )
    return f"{_percent(clear / (bare + clear))} of {bare + clear}" if bare + clear else "none"


def _percent(share: float) -> str:
    return f"{share:.0%}".replace("%", " %")


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


_PAGE = """## On real photographs

`python -m makeup_video.training.worn.real_photos` measures this section on photographs that no net
was trained on, labelled by eye. A face is *bare* or *clear* of each kind of makeup; faces in
between are left out. Thresholds and calibration were chosen on the same photographs.

{worn}

How much of a photo's makeup comes across to five bare faces: each zone of the face is compared with
plain skin in CIELAB, 0 is a bare face and 1 the photo. A perfect transfer does not reach 1, because
bare faces differ as well. Photos count in the zones where they are clearly made up.

{zones}

ROC curves over all these faces, bare, labelled and made up. Each column is a rate of false alarms:
bare faces that are read as wearing the kind. Below it stands the share of clear ones that is found:

{roc}

The columns group the same faces by the probability that was read. Below each stands the share that
clearly wear the kind:

{curves}
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--labelled", type=existing, required=True)
    parser.add_argument("--looks", type=existing, nargs="+", required=True)
    parser.add_argument("--bare", type=existing, required=True)
    parser.add_argument("--page", type=existing)
    parser.add_argument("--sheets", type=Path)
    parser.add_argument("--step", type=int, default=1, help="every how many-th photo; a trial")
    options = parser.parse_args()
    if options.sheets is not None:
        options.sheets.mkdir(parents=True, exist_ok=True)
    looks = [path for folder in options.looks for path in sorted(folder.glob("*.jpg"))]
    bare = sorted(options.bare.glob("*.jpg"))
    transfer = transfer_of(looks[:: options.step], bare, options.sheets)
    made_up = [worn_of(folder, options.step) for folder in options.looks if has_table(folder)]
    labelled, plain = (worn_of(each, options.step) for each in (options.labelled, options.bare))
    text = section(labelled, plain, made_up, transfer)
    print(text)
    if options.page is not None:
        before, _, rest = options.page.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        options.page.write_text(f"{before}{BEGIN}\n{text}{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
