"""Measure the reference nets and write docs/results.md and its pictures.

    python docs/make/make_results.py --data runs/reference.npz --lip-shades lip_shades.csv \\
        --eye-shades eyeshadow_shades.csv

The script needs the extra `train`. It keeps the text of the page under the heading JUDGEMENT.
"""

import argparse
import time
from collections.abc import Mapping
from pathlib import Path

import contact_sheet as sheet
import numpy as np
import results_page as page
import results_pictures as pictures
from makeup_video.pipeline.reference.crops import CROPPED
from makeup_video.training.reference.draw_products import SPLITS
from makeup_video.training.reference.evaluate import COUNT, Measured, calm, held_out, measure
from makeup_video.training.reference.people import People
from makeup_video.training.reference.picture_metrics import Whole, whole_scores
from makeup_video.training.reference.prepare import TONE_NAMES
from makeup_video.training.reference.read_look import Net, cost_of, file_of, nets_of
from makeup_video.training.reference.triplets import EXTREMES, OfColour, halves, triplets

SHIPPED = sheet.DOCS.parent / "pipeline" / "weights"
BOTH = "lips and eyes"
SETS = {"lips": ("lips",), "eyes": ("eyes",), BOTH: CROPPED}

Nets = Mapping[str, Mapping[str, Net]]


class Measuring:
    """Measures the nets on the test people and held-out products."""

    def __init__(self, options: argparse.Namespace, nets: Nets, whole: Whole) -> None:
        self.options, self.nets, self.whole = options, nets, whole
        self.first = dict([next(iter(nets.items()))])
        tables = {"lips": options.lip_shades, "eyes": options.eye_shades}
        self.products = {region: held_out(path, region) for region, path in tables.items()}

    def main(self) -> dict[str, Measured]:
        """Measure on test people by worn regions: one half wears looks, the other half is bare."""
        found = {}
        for at, (name, regions) in enumerate(SETS.items()):
            people = People(self.options.data, regions, "test")
            made = triplets(
                people, *halves(people), {region: self.products[region] for region in regions},
                self.options.count, seed=at,
            )  # fmt: skip
            found[name] = measure(made, self.nets, self.whole, with_product=True)
            log(f"{name}: {self.options.count} triplets")
        return found

    def extremes(self) -> dict[str, dict[str, Measured]]:
        """Measure products of extreme colours, by region and colour."""
        found: dict[str, dict[str, Measured]] = {}
        for region in CROPPED:
            people = People(self.options.data, region, "test")
            found[region] = {}
            for at, (name, rgb) in enumerate(EXTREMES.items()):
                products = {region: OfColour(self.products[region], rgb)}
                count = max(self.options.count // 6, 2)
                made = triplets(people, *halves(people), products, count, seed=100 + at)
                found[region][name] = measure(made, self.first, self.whole)
        log("extreme colours")
        return found

    def tones(self, data: Path, *splits: str) -> dict[str, dict[str, Measured]]:
        """Measure by region and skin tone of the wearer, with the same number of looks for each."""
        found: dict[str, dict[str, Measured]] = {}
        for region in CROPPED:
            people = People(data, region, *splits)
            found[region] = {}
            everybody = np.arange(len(people))
            for tone in np.unique(people.tone):
                count = max(self.options.count // 4, 2)
                products = {region: self.products[region]}
                wearers = everybody[people.tone == tone]
                made = triplets(people, wearers, everybody, products, count, seed=200 + int(tone))
                found[region][TONE_NAMES[tone]] = measure(made, self.first)
        log(f"skin tones of {data.name}")
        return found


def log(line: str) -> None:
    print(time.strftime("%H:%M:%S"), line, flush=True)


def named(text: str) -> tuple[str, Path]:
    """Split "lite0=runs/lite0" into name and folder; the name defaults to that of the folder."""
    name, _, folder = text.rpartition("=")
    return name or Path(folder).name, Path(folder)


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--nets", type=named, nargs="+", default=[("shipped", SHIPPED)], metavar="NAME=DIR",
        help="folders with reference_REGION.onnx or REGION-*.pt; the first is measured in full",
    )  # fmt: skip
    parser.add_argument("--data", type=Path, default=Path("runs/reference.npz"))
    parser.add_argument("--more", type=Path, help="other people, as packed by `prepare`")
    parser.add_argument("--lip-shades", type=Path, required=True)
    parser.add_argument("--eye-shades", type=Path, required=True)
    parser.add_argument(
        "--lpips-weights",
        type=Path,
        nargs="+",
        default=[],
        help="weights of AlexNet and of LPIPS; see lpips.py",
    )
    parser.add_argument(
        "--count", type=int, default=COUNT, help="number of triplets; fewer for a trial"
    )
    parser.add_argument("--out", type=Path, default=page.PAGE)
    parser.add_argument("--pictures", type=Path, default=sheet.DOCS / sheet.PICTURES)
    parser.add_argument(
        "--look-at", type=Path, help="folder for grids of the test people, for viewing"
    )
    parser.add_argument(
        "--clips", type=Path, help="folder for samples/in.mp4 painted with read looks"
    )
    return parser.parse_args()


def main() -> None:
    options = parse_arguments()
    calm()
    nets = {name: nets_of(folder) for name, folder in options.nets}
    if next(iter(nets.values())).keys() != set(CROPPED):
        raise SystemExit(f"{options.nets[0][1]} has no nets for both of {', '.join(CROPPED)}")
    costs = {
        name: {
            region: cost_of(path, region)
            for region in CROPPED
            if (path := file_of(folder, region))
        }
        for name, folder in options.nets
    }  # fmt: skip
    measuring = Measuring(options, nets, whole_scores(options.lpips_weights))
    results = page.Results(
        main=measuring.main(),
        extremes=measuring.extremes(),
        tones=measuring.tones(options.data, "validation", "test"),
        more=measuring.tones(options.more, *SPLITS) if options.more else {},
        nets=list(nets),
        costs=costs,
    )
    judgement = sheet.kept_after(options.out, page.JUDGEMENT)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(page.text(results) + judgement, encoding="utf-8")
    log(f"wrote {options.out}")
    first = next(iter(nets.values()))
    pictures.save_all(first, options.pictures)
    if options.look_at:
        for region in CROPPED:
            people = People(options.data, region, "test")
            made = triplets(
                people, *halves(people), {region: measuring.products[region]}, 12, seed=300
            )
            pictures.save_test_people(made, region, first, options.look_at)
    if options.clips:
        pictures.save_clips(first, options.clips)


if __name__ == "__main__":
    main()
