"""Evaluates reference nets on people and products that they never saw.

    python -m makeup_video.training.reference.evaluate lips runs/lips-lite0.pt \\
        --shades lip_shades.csv

The look that a net estimates and the true look are painted on another bare person and compared
there. So is the look that the whole product reads without being told the worn kinds and their
places. Parts of the product (the colours of bare and of made-up skin, how lipstick shines and
fades, which makeup is worn) were fitted on faces that include these people.
docs/make/make_results.py measures everything and writes it to docs/results.md.
"""

import argparse
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.reference.crops import CROPPED, NUMBERS
from makeup_video.pipeline.reference.estimate import estimate
from makeup_video.pipeline.render.composite import Composite
from makeup_video.training.inputs import existing, made_by
from makeup_video.training.reference.baselines import transfer_mean_colour
from makeup_video.training.reference.draw_products import (
    COLOUR,
    COLOUR_SEEN,
    SPLITS,
    RealProducts,
    errors_in_words,
    read_products,
)
from makeup_video.training.reference.people import People
from makeup_video.training.reference.picture_metrics import (
    WHOLE,
    Whole,
    ciede2000,
    crop_face,
    face_crop_to_px,
)
from makeup_video.training.reference.read_look import (
    Net,
    Seen,
    cut,
    look_seen,
    look_with,
    net_of,
    see,
)
from makeup_video.training.reference.rendered_crops import Draws, paint, to_rgb8
from makeup_video.training.reference.triplets import (
    Triplet,
    halves,
    numbers_of,
    triplets,
    weight_of,
    worn,
)
from scipy.stats import spearmanr

COUNT = 300
TRUE, MEAN, SOURCE = "true numbers", "mean colour", "source unchanged"
KNOWN = "known points and light"
PRODUCT = "the whole product"
MEASURES = ("CIEDE2000", *WHOLE)


@dataclass(frozen=True, eq=False)
class Measured:
    """The results of an evaluation.

    numbers: by name and region, (N, 7): the TRUE numbers of the look, those that each set of nets
    reads, and the KNOWN ones, which the first set reads with the points and light of the bare
    portrait.

    scores: by method (a set of nets, PRODUCT, TRUE, MEAN, SOURCE), (N, 4) MEASURES.
    person, tone: (N,) of the wearers.
    unread: how many photos had no face that was found. `numbers` leaves them out, and for `scores`
    their source stays unpainted.
    """

    numbers: dict[str, dict[str, np.ndarray]]
    scores: dict[str, np.ndarray]
    person: np.ndarray
    tone: np.ndarray
    unread: int

    def only(self, method: str, measure: str = MEASURES[0]) -> np.ndarray:
        """Scores (N,) of one method and measure."""
        return self.scores[method][:, MEASURES.index(measure)]

    def pair(self, name: str, region: str) -> tuple[np.ndarray, np.ndarray]:
        """(N, 7) true and read numbers."""
        return self.numbers[TRUE][region], self.numbers[name][region]


def colour_error(true: np.ndarray, estimated: np.ndarray) -> float:
    """Mean absolute error of red, green and blue where the product covers; code values of 255."""
    shows = true[:, 0] >= COLOUR_SEEN
    return float(np.abs(estimated - true)[shows, COLOUR].mean()) if shows.any() else np.nan


def gloss_rank(true: np.ndarray, estimated: np.ndarray) -> float:
    """Spearman's rank correlation between true and read gloss."""
    gloss = NUMBERS.index("gloss")
    return float(spearmanr(true[:, gloss], estimated[:, gloss]).statistic)


def held_out(path: Path, region: str) -> RealProducts:
    """The products of the test split of a shade table."""
    products = read_products(path, region)
    return RealProducts(products.values[products.split == SPLITS.index("test")])


def measure(
    made: Iterable[Triplet],
    nets: Mapping[str, Mapping[str, Net]],
    whole: Whole | None = None,
    with_product: bool = False,
) -> Measured:
    """Measures nets on triplets.

    nets: by name, then by region; only the first must have all regions. whole: metrics of the whole
    face; None: only CIEDE2000. with_product: also score the look that the whole product reads.
    """
    composite, first = Composite(Look()), next(iter(nets.values()))
    numbers: dict[str, dict[str, list[np.ndarray]]] = {}
    scores: dict[str, list[np.ndarray]] = {}
    who, unread = [], 0
    for one in made:
        who.append((one.person, one.tone))
        seen, regions = see(one.photo), worn(one.look)
        able = {name: each for name, each in nets.items() if each.keys() >= set(regions)}
        read = {name: _read(seen, each, one.look) for name, each in able.items()}
        if seen:
            own = cut(one.photo, one.wearer.scene.faces[0].face, one.wearer.light)
            known = _read(own, first, one.look)
            for name, look in {TRUE: one.look, KNOWN: known, **read}.items():
                for region in worn(look):
                    rows = numbers.setdefault(name, {}).setdefault(region, [])
                    rows.append(numbers_of(look, region))
        unread += seen is None
        painted = {**read, PRODUCT: read_by_product(one)} if with_product else read
        for method, score in _scores(one, seen, painted, composite, whole).items():
            scores.setdefault(method, []).append(score)
    person, tone = np.array(who).T
    stacked = {name: _stacked(by_region) for name, by_region in numbers.items()}
    return Measured(stacked, _stacked(scores), person, tone, unread)


def _stacked(rows: Mapping[str, list[np.ndarray]]) -> dict[str, np.ndarray]:
    return {key: np.array(values) for key, values in rows.items()}


def _read(seen: Seen | None, nets: Mapping[str, Net], look: Look) -> Look:
    """The look that the nets read in the regions that wear something; the zone is given."""
    if seen is None:
        return Look()
    chosen = {region: nets[region] for region in worn(look) if region in nets}
    return look_seen(seen, chosen, look.zone)


def read_by_product(one: Triplet) -> Look:
    """The look that the product reads from the photo, in the regions that wear something.

    Unlike the nets, the product must detect that they are made up, and where eyeshadow lies.
    """
    try:
        found = estimate(one.photo).look
    except PhotoError:
        return Look()
    return Look([layer for layer in found.layers if KINDS[layer.kind].part in worn(one.look)])


def _scores(
    one: Triplet,
    seen: Seen | None,
    read: Mapping[str, Look],
    composite: Composite,
    whole: Whole | None,
) -> dict[str, np.ndarray]:
    """MEASURES (4,) of each method."""
    source = to_rgb8(one.bare.codes)
    numbers = {region: numbers_of(one.look, region) for region in worn(one.look)}
    looks = {**read, TRUE: look_with(numbers, one.look.zone)}
    made = {name: paint(composite, one.bare, look) for name, look in looks.items()}
    made[MEAN] = _mean_colour(one, seen, source) if seen else source
    made[SOURCE] = source
    rest = np.full((len(made), len(WHOLE)), np.nan)
    if whole:
        to_px = face_crop_to_px(one.bare.scene.faces[0].face)
        faces = [crop_face(picture, to_px) for picture in made.values()]
        rest = whole(faces, crop_face(one.truth, to_px))
    return {
        name: np.array([ciede2000(picture, one.truth, one.where), *row])
        for (name, picture), row in zip(made.items(), rest, strict=True)
    }


def _mean_colour(one: Triplet, seen: Seen, source: np.ndarray) -> np.ndarray:
    for region in worn(one.look):
        there, here = (
            weight_of(face, region, one.look.zone, (rgb8.shape[1], rgb8.shape[0]))
            for face, rgb8 in ((seen.face, one.photo), (one.bare.scene.faces[0].face, source))
        )
        source = transfer_mean_colour(one.photo, there, source, here)
    return source


def _line(name: str, off: np.ndarray) -> str:
    return f"{name}: median {np.median(off):.2f}, 90 % {np.quantile(off, 0.9):.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("region", choices=CROPPED)
    parser.add_argument("net", type=existing, help="a checkpoint, or an exported .onnx file")
    parser.add_argument("--data", type=made_by("reference.prepare"), default="runs/reference.npz")
    parser.add_argument("--shades", type=existing, required=True)
    parser.add_argument("--count", type=int, default=COUNT)
    options = parser.parse_args()
    calm()
    people = People(options.data, options.region, "test")
    products: dict[str, Draws] = {options.region: held_out(options.shades, options.region)}
    made = triplets(people, *halves(people), products, options.count, seed=2)
    nets = {"estimated": {options.region: net_of(options.net)}}
    found = measure(made, nets, with_product=True)
    true, estimated = found.pair("estimated", options.region)
    print("mean errors:", errors_in_words(true, estimated))
    print(
        f"colour {colour_error(true, estimated):.1f}; "
        f"gloss: rank correlation {gloss_rank(true, estimated):.3f}"
    )
    print(f"CIEDE2000 to the true look, {len(found.tone)} times, {found.unread} without a face")
    for method in found.scores:
        print(_line(f"  {method}", found.only(method)))


def calm() -> None:
    """Sets one thread for each library: pictures are small, and more threads would only wait."""
    os.environ["POCL_MAX_PTHREAD_COUNT"] = "1"
    cv2.setNumThreads(1)
    torch.set_num_threads(1)


if __name__ == "__main__":
    main()
