"""Finds the faces of portraits, as the product does, and selects those without makeup.

    python -m makeup_video.training.reference.prepare --portraits DIR --out runs/reference.npz

DIR holds pictures and labels.npz with their names and, where there are several, sources. Painting
the packed portraits needs no net. Many people in portraits wear makeup, and their portraits are not
painted: DIR/worn.csv, described in worn/prepare.py, lists which lips and eyes are bare. Without
that table the colour of lips and lids is predicted from the colour of the skin. The portraits
furthest from the prediction then count as made up.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.faces.lip_mask import lip_mask
from makeup_video.pipeline.reference.crops import CROPPED
from makeup_video.pipeline.render.surfaces.both_eyes import OUTWARDS
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from makeup_video.training.faces.evaluate import CHEEKS, skin_tone
from makeup_video.training.inputs import existing
from makeup_video.training.worn.prepare import LABELS, rows
from makeup_video.training.worn.table import has_table

# As in faces/prepare.py, the last pictures of each source are held out. The first of these are for
# validation. The others are for the test: no face net was trained on them either.
VALIDATION_SHARE, TEST_SHARE = 0.06, 0.08
WORN_SHARE = 1 / 3  # of each skin tone: the portraits that look most made up
SHOWS = {"lips": ("lips",), "eyes": ("shadow", "liner")}  # the labels of LABELS that a region shows
# Limits of the individual typology angle: dark, brown, tan ... very light.
TONES_DEGREES = (-30, 10, 28, 41, 55)
TONE_NAMES = ("dark", "brown", "tan", "medium", "light", "very light")
_GREY = 4.0  # least chroma of skin: a black and white photo shows no colour of a product
_SHINE = 95  # percentile of lightness: the lips' highlights


def lab_of(rgb8: np.ndarray) -> np.ndarray:
    """(N, 3) uint8 -> (N, 3) CIE Lab."""
    lab: np.ndarray = cv2.cvtColor((rgb8[None] / 255).astype(np.float32), cv2.COLOR_RGB2Lab)[0]
    return lab


def colours_of(rgb8: np.ndarray, face: Face) -> np.ndarray | None:
    """(10,) the CIE Lab of skin, lips and lids, and the shine of the lips.

    None when a part cannot be seen.
    """
    height, width = rgb8.shape[:2]
    at = np.rint(face.points_px[CHEEKS, :2]).astype(int)
    if (at < 4).any() or (at >= (width - 4, height - 4)).any():
        return None
    skin = np.concatenate([rgb8[y - 4 : y + 5, x - 4 : x + 5].reshape(-1, 3) for x, y in at])
    lips = rgb8[lip_mask(rgb8, face) > 0.9]
    lids = []
    for eye in lid_surfaces(face):
        is_lid = (eye.up > 0.2) & (eye.up < 1) & (np.abs(OUTWARDS) < 0.4)
        x, y = np.rint(eye.grid.places()).astype(int)[:, is_lid.ravel()]
        inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        lids.append(rgb8[y[inside], x[inside]])
    if len(lips) < 60 or not lids or sum(map(len, lids)) < 20:
        return None
    parts = [lab_of(skin), lab_of(lips), lab_of(np.concatenate(lids))]
    medians = [np.median(part, 0) for part in parts]
    shine = np.percentile(parts[1][:, 0], _SHINE) - medians[1][0]
    return np.array([*np.concatenate(medians), shine])


def beyond_skin(part: np.ndarray, skin: np.ndarray) -> np.ndarray:
    """(N, 3) differences between the Lab of a part and its prediction from the Lab of the skin.

    The prediction is linear, fitted to the two thirds of the portraits that lie closest to it: the
    others are taken to wear makeup.
    """
    known = np.column_stack([np.ones(len(skin)), skin])
    near = np.ones(len(part), bool)
    for _ in range(6):
        line = np.linalg.lstsq(known[near], part[near], rcond=None)[0]
        off = part - known @ line
        far = (off**2 / off[near].var(0)).sum(1)
        near = far <= np.quantile(far, 1 - WORN_SHARE)
    return off


def standard(x: np.ndarray) -> np.ndarray:
    return (x - np.median(x)) / x.std()


def made_up(colours: np.ndarray) -> dict[str, np.ndarray]:
    """Colours (N, 10) from `colours_of` -> for each region, (N,) how made up it looks."""
    skin, lips, lids, shine = np.split(colours, (3, 6, 9), axis=1)
    off = beyond_skin(lips, skin)
    redder, yellower = off[:, 1], off[:, 2]
    lip_score = standard(np.hypot(redder, yellower)) + standard(redder) + 0.5 * standard(-off[:, 0])
    lip_score += 0.7 * standard(shine[:, 0])
    off = beyond_skin(lids, skin)  # eyeshadow may be of any colour, lighter or darker
    lid_score = (off**2 / off.var(0)).sum(1)
    return {"lips": lip_score, "eyes": lid_score}


def bare(score: np.ndarray, tone: np.ndarray) -> np.ndarray:
    """(N,) bool: True for all but the third of each skin tone that looks most made up."""
    kept = np.zeros(len(score), bool)
    for one in np.unique(tone):
        of = np.flatnonzero(tone == one)
        kept[of[score[of] <= np.quantile(score[of], 1 - WORN_SHARE)]] = True
    return kept


def labelled_bare(folder: Path, names: np.ndarray) -> dict[str, np.ndarray]:
    """For each region, (N,) whether it is labelled as bare; a picture without labels is not."""
    labels = {path.name: dict(zip(LABELS, values, strict=True)) for path, values in rows(folder)}
    return {
        region: np.array([
            name in labels and not any(labels[name][label] for label in shown) for name in names
        ])
        for region, shown in SHOWS.items()
    }  # fmt: skip


def split_of(source: np.ndarray) -> np.ndarray:
    """(N,) index into draw_products.SPLITS, by the order within each source."""
    split = np.zeros(len(source), np.int64)
    for name in np.unique(source):
        index = np.flatnonzero(source == name)
        part = np.arange(len(index)) / len(index)
        split[index] = np.searchsorted((1 - TEST_SHARE - VALIDATION_SHARE, 1 - TEST_SHARE), part,
                                       side="right")  # fmt: skip
    return split


def entry_of(path: Path) -> dict[str, np.ndarray] | None:
    """The entry of a portrait; None unless it has exactly one face that can be painted."""
    data = np.frombuffer(path.read_bytes(), np.uint8)
    rgb8 = np.ascontiguousarray(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1])
    faces = find_faces(rgb8)
    if len(faces) != 1 or faces[0].mouth_weight < 1:
        return None
    colours = colours_of(rgb8, faces[0])
    if colours is None or np.hypot(*colours[1:3]) < _GREY:
        return None
    return {
        "picture": data, "points": faces[0].points_px,
        "logits": faces[0].lips.logits.astype(np.float16), "to_px": faces[0].lips.to_px,
        "colours": colours,
        "tone": np.searchsorted(TONES_DEGREES, skin_tone(rgb8, faces[0].points_px)),
    }  # fmt: skip


def pack(
    found: list[dict[str, np.ndarray]],
    split: np.ndarray,
    labelled: dict[str, np.ndarray] | None = None,
) -> dict[str, np.ndarray]:
    """One array per column; the pictures are one array of the bytes of their files.

    labelled: for each region, (N,) whether it is labelled as bare; None: its colours decide.
    """
    packed = {
        key: np.stack([entry[key] for entry in found]) for key in found[0] if key != "picture"
    }
    pictures = [entry["picture"] for entry in found]
    scores = made_up(packed["colours"])
    if labelled is None:
        labelled = {name: bare(score, packed["tone"]) for name, score in scores.items()}
    return {
        **packed, "split": split,
        "pictures": np.concatenate(pictures), "ends": np.cumsum([len(data) for data in pictures]),
        **{f"made_up_{name}": score for name, score in scores.items()},
        **{f"bare_{name}": is_bare for name, is_bare in labelled.items()},
    }  # fmt: skip


def report(packed: dict[str, np.ndarray]) -> None:
    for name in CROPPED:
        kept = packed[f"bare_{name}"]
        counts = [
            f"{TONE_NAMES[tone]} {kept[of].sum()} of {of.sum()}"
            for tone in range(len(TONE_NAMES))
            if (of := packed["tone"] == tone).any()
        ]
        print(f"bare {name}: {kept.sum()} of {len(kept)}; {', '.join(counts)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--portraits", type=existing, required=True)
    parser.add_argument("--out", type=Path, default=Path("runs/reference.npz"))
    parser.add_argument(
        "--every", type=int, default=1, help="take every Nth portrait, to try it out"
    )
    options = parser.parse_args()
    cv2.setNumThreads(1)
    labels = np.load(options.portraits / "labels.npz")
    chosen = np.arange(0, len(labels["name"]), options.every)
    seen = [entry_of(options.portraits / name) for name in labels["name"][chosen]]
    found = [entry for entry in seen if entry is not None]
    source = labels["source"] if "source" in labels else np.full(len(labels["name"]), "")
    kept = np.array([entry is not None for entry in seen])
    labelled = (
        labelled_bare(options.portraits, labels["name"][chosen][kept])
        if has_table(options.portraits)
        else None
    )
    packed = pack(found, split_of(source[chosen])[kept], labelled)
    print(f"{len(found)} of {len(chosen)} portraits have one face that can be painted")
    report(packed)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    np.savez(options.out, **packed)


if __name__ == "__main__":
    main()
