"""Write the page docs/results.md from the measurements of make_results.py."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import contact_sheet as sheet
import numpy as np
import results_pictures as pictures
from makeup_video.pipeline.reference.crops import NUMBERS
from makeup_video.training.reference.draw_products import COLOUR_SEEN, number_errors
from makeup_video.training.reference.evaluate import (
    KNOWN,
    MEAN,
    MEASURES,
    PRODUCT,
    SOURCE,
    TRUE,
    Measured,
    colour_error,
    gloss_rank,
)
from makeup_video.training.reference.picture_metrics import FACE_PX
from makeup_video.training.reference.read_look import Cost
from makeup_video.training.reference.rendered_crops import TEST_QUALITY
from makeup_video.training.worn.real_photos import BEGIN, END

PAGE = Path(__file__).parents[1] / "results.md"
JUDGEMENT = "## What still goes wrong"
# The goals: CIEDE2000 (median, 90th percentile), colour error of 255, rank correlation of gloss.
REACH_CIEDE = {"lips": (2.5, 6.0), "eyes": (3.0, 7.0)}
REACH_COLOUR, REACH_GLOSS = 12.0, 0.8
# The paper's lipstick net (Kips et al., 2021): a table that is commented out in the LaTeX source of
# the supplement, with the paper's own parameter names; and table 1, on CA-GAN's photographed
# triplets.
PAPER_MAE = {"red": "28.25", "green": "89.93", "blue": "83.64", "gloss": "0.29 (wetness, 0 to 1)",
             "gloss_roughness": "0.29 (glossDetail)"}  # fmt: skip
PAPER_TRIPLETS = {"BeautyGAN": (0.123, 0.371, 0.093), "CA-GAN": (0.085, 0.304, 0.077),
                  "the paper": (0.083, 0.283, 0.060)}  # fmt: skip
_RANGES = {"red": "0 to 255", "green": "0 to 255", "blue": "0 to 255", "gloss": "0 to 4"}
_METHODS = {
    PRODUCT: "the whole product (which makeup is worn, and where, is not given)",
    TRUE: "the true parameters (the best possible)",
    MEAN: "mean colour moved",
    SOURCE: "source unchanged",
}
_UNMEASURED, MISSED = "not measured", "**missed**"


@dataclass(frozen=True, eq=False)
class Results:
    """All measurements behind the page.

    main: by worn regions.  extremes, tones, more: by region, then by colour or tone.
    nets: their names; the other tables measure the first.  costs: by net and region.
    """

    main: Mapping[str, Measured]
    extremes: Mapping[str, Mapping[str, Measured]]
    tones: Mapping[str, Mapping[str, Measured]]
    more: Mapping[str, Mapping[str, Measured]]
    nets: Sequence[str]
    costs: Mapping[str, Mapping[str, Cost]]


def number(value: float, digits: int = 3) -> str:
    return _UNMEASURED if np.isnan(value) else f"{value:.{digits}f}"


def median_and_most(off: np.ndarray) -> tuple[float, float]:
    median, most = np.quantile(off, (0.5, 0.9)).tolist()
    return median, most


def reach(results: Results) -> str:
    """Return the table of goals and measured values, missed goals first."""
    rows = []
    for region in REACH_CIEDE:
        for what, limit, measured, met in _reach_of(results.main[region], results.nets[0], region):
            rows.append((f"{region}: {what}", limit, measured, "reached" if met else MISSED))
    return sheet.table(("", "goal", "measured", ""), sorted(rows, key=lambda row: row[3] != MISSED))


def _reach_of(found: Measured, ours: str, region: str) -> Iterator[tuple[str, str, str, bool]]:
    """Yield each measure, its goal, its value, and whether the goal is reached."""
    for name, most, off in zip(
        ("median", "90 %"), REACH_CIEDE[region], median_and_most(found.only(ours)), strict=True
    ):
        yield f"CIEDE2000, {name}", f"<= {most:g}", number(off, 2), off <= most
    off = colour_error(*found.pair(ours, region))
    yield "colour, mean error of 255", f"<= {REACH_COLOUR:g}", number(off, 1), off <= REACH_COLOUR
    rank = gloss_rank(*found.pair(ours, region))
    yield "gloss, rank correlation", f">= {REACH_GLOSS:g}", number(rank, 2), rank >= REACH_GLOSS
    for measure in MEASURES:
        mine, simple = (found.only(method, measure).mean() for method in (ours, MEAN))
        if not np.isnan(mine):
            limit = f"< {number(simple, 5)} (mean colour moved)"
            yield f"{measure}, mean", limit, number(mine, 5), mine < simple


def numbers_table(results: Results) -> str:
    rows = []
    pairs = {region: results.main[region].pair(results.nets[0], region) for region in REACH_CIEDE}
    errors = {region: number_errors(*pair) for region, pair in pairs.items()}
    for at, name in enumerate(NUMBERS):
        digits = 1 if name in ("red", "green", "blue") else 3
        mine = (number(errors[region][at], digits) for region in REACH_CIEDE)
        rows.append((f"`{name}`", _RANGES.get(name, "0 to 1"), *mine, PAPER_MAE.get(name, "")))
    for label, how in (
        ("colour, all three", colour_error),
        ("gloss, rank correlation", gloss_rank),
    ):
        mine = (number(how(*pair), 2) for pair in pairs.values())
        rows.append((label, "", *mine, ""))
    return sheet.table(("", "range", "lips", "eyes", "the paper, lips"), rows)


def known_line(results: Results) -> str:
    """Return how much detecting the face and its light in the made-up photo costs."""
    parts = []
    for region in REACH_CIEDE:
        found = results.main[region]
        end, known = (colour_error(*found.pair(name, region)) for name in (results.nets[0], KNOWN))
        parts.append(f"{region} {number(known, 2)} in place of {number(end, 2)}")
    lost = sum(found.unread for found in results.main.values())
    count = sum(len(found.tone) for found in results.main.values())
    return (
        "Face points and light are read from the made-up photo itself. With those of the bare\n"
        f"portrait the mean error of colours would be: {'; '.join(parts)}.\n"
        f"A face was found in {count - lost} of {count} photos."
    )


def triplet_tables(results: Results) -> str:
    """Return a table for each combination of worn regions."""
    parts = []
    for worn, found in results.main.items():
        methods = {results.nets[0]: "**the nets**", **_METHODS}
        rows = []
        for method, label in methods.items():
            if method not in found.scores:
                continue
            median, most = median_and_most(found.only(method))
            whole = (number(found.only(method, name).mean(), 5) for name in MEASURES[1:])
            rows.append((label, f"{median:.2f}", f"{most:.2f}", *whole))
        if worn == "lips":
            rows += [
                (f"{name}, *other photos*", "", "", *(f"{value:.3f}" for value in values))
                for name, values in PAPER_TRIPLETS.items()
            ]
        head = (f"{worn}, {len(found.tone)} triplets", "CIEDE2000, median", "90 %", *MEASURES[1:])
        parts.append(sheet.table(head, rows))
    return "\n\n".join(parts)


def by_kind(ours: str, kinds: Mapping[str, Mapping[str, Measured]], what: str) -> str:
    """Return a table with a row for each region and colour or tone.

    The measures of the whole face are given for colours only.
    """
    whole, rows = MEASURES[1:] if what == "colour" else (), []
    for region, by_name in kinds.items():
        for name, found in by_name.items():
            people = f"{len(np.unique(found.person))}, {len(found.tone)}"
            off = *median_and_most(found.only(ours)), float(np.median(found.only(MEAN)))
            error = colour_error(*found.pair(ours, region))
            rest = (number(found.only(ours, measure).mean(), 5) for measure in whole)
            rows.append((region, name, people, *(f"{x:.2f}" for x in off), number(error, 1), *rest))
    head = ("", what, "people, looks", "CIEDE2000, median", "90 %", "median of mean colour moved")
    return sheet.table((*head, "colour, of 255", *whole), rows)


def nets_table(results: Results) -> str:
    rows = []
    for name in results.nets:
        for region, cost in results.costs[name].items():
            found = results.main[region]
            pair = found.pair(name, region)
            size = f"{cost.megabytes:.1f}", *(f"{ms:.1f}" for ms in cost.ms.values())
            off = (f"{x:.2f}" for x in median_and_most(found.only(name)))
            numbers = number(colour_error(*pair), 1), number(gloss_rank(*pair), 2)
            whole = (number(found.only(name, measure).mean(), 5) for measure in MEASURES[1:])
            rows.append((name, region, *size, *off, *numbers, *whole))
    head = ("net", "", "MB", "ms, 1 thread", "ms, 2 threads", "CIEDE2000, median", "90 %")
    return sheet.table((*head, "colour, of 255", "gloss, rank", *MEASURES[1:]), rows)


def text(results: Results) -> str:
    """Return the page down to the heading JUDGEMENT."""
    parts = (_beginning, _triplets, _kinds, _end)
    return "\n".join(part(results) for part in parts) + f"\n{JUDGEMENT}\n"


def kept_section(path: Path = PAGE) -> str:
    """Return what training/worn/real_photos.py wrote into a page, with its markers."""
    old = path.read_text(encoding="utf-8") if path.exists() else ""
    return BEGIN + old.partition(BEGIN)[2].partition(END)[0] + END


def _beginning(results: Results) -> str:
    return f"""# Results: how well a look is read from one photo

{kept_section()}

## On rendered photos

`python docs/make/make_results.py` measures what follows, down to the last heading of the page. The
people and the products are unseen by the nets that read lips and eyes. The net that reads what is
worn, which the rows of the whole product use as well, has seen a quarter of these people bare, and
all shades. The colours of bare and of worn skin and the net of how lipstick shines and fades, which
the product uses beside it, were fitted on faces that include all of them.

The renderer paints each look with all of its 17 parameters, including those that no net estimates.
The photos are saved as JPEG {TEST_QUALITY}. The look is then read from such a photo alone, as the
nets do: find the face, read the light, cut the crop, estimate seven parameters, and take the
others from the nearest finish. People are drawn so that all skin tones that occur are about
equally frequent; none of them is labelled as made up.

The tables measure the nets by themselves: they are given which makeup is worn, and where. The
product takes from these nets only the roughness of the gloss of lips and a little of the
reflection of lips. It measures the colours of all makeup, and the shimmer of lids, on the photo.
The rows *the whole product* under [Triplets](#triplets) show what it reads when nothing is
given. On renders it reads worse than its nets, because it was made for real photographs
([decisions](decisions/reference.md)). It takes most of the difference between a photo's skin and
typical skin for exposure, while in these renders the skin itself differs. It also calls many
painted eyeshadows bare, and lipsticks that are close to bare lips, because for each kind its
thresholds let only one bare real face in seven pass as made up. It judges the gloss of lips by a
net that learned from real mouths, and by highlights.

### Goals

CIEDE2000 compares the look that was read with the true look. Both are painted on the same other,
bare person, and the painted pixels are compared.

{reach(results)}

### Error of each parameter

The table gives the mean absolute error. Colours count where opacity is at least {COLOUR_SEEN:g},
because a sheerer product shows little of its colour. The paper's figures are from a table that is
commented out in its source. Its parameters are defined slightly differently, and one more (gamma,
error 1.42, any positive value) has no counterpart here.

{numbers_table(results)}

{known_line(results)}
"""


def _triplets(results: Results) -> str:
    return f"""### Triplets

A triplet is a photo of a person who wears the look, a photo of another, bare person, and that bare
person with the same look as the truth. The wearers are one half of the test people, the bare people
the other. L1, MS-SSIM (of R'G'B') and LPIPS compare the whole face at {FACE_PX} x {FACE_PX} px,
with values 0 to 1. The makeup is a small part of that area.

The paper's figures (its table 1, lipstick) are from other, photographed triplets, in which the two
photos of a person differ in more than makeup. Compare these figures with each other, not with ours.

*Mean colour moved* is what a simple tool does: it shifts the mean Lab of the region to that of the
reference and keeps the detail.

{triplet_tables(results)}
"""


def _kinds(results: Results) -> str:
    ours = results.nets[0]
    more = f"""
The next table is measured on real photographs. Neither the nets nor the renderer were developed on
these people or in this light. People who look made up were left out. The tone is that of the cheeks
in the photo, so a shadow or a coloured lamp affects it.

{by_kind(ours, results.more, "tone")}
""" if results.more else ""  # fmt: skip
    return f"""### Extreme colours

Blue, green, black, white and yellow products with opacity 0.6 to 1. Their other parameters are
drawn like those of real products.

{by_kind(ours, results.extremes, "colour")}

### Skin tones

The rows are skin tones of the wearer (individual typology angle of the cheeks), for people of the
validation and test sets. The validation people were monitored during training, but no net was
trained on them. Some rows have very few people.

{by_kind(ours, results.tones, "tone")}
{more}"""


def _end(results: Results) -> str:
    return f"""### Nets

Size of the weights, time of one crop, and the measures above on the same triplets.

{nets_table(results)}

### Pictures

A look is painted on a reference, read from that photo saved as JPEG {TEST_QUALITY}, and painted on
another picture, beside the truth. Lipsticks go from Grace Hopper to Eileen Collins. Hopper's lids
are behind the rims of her glasses. So eyeshadow goes from the photograph of Collins to a frame of
`samples/in.mp4`, which is made from that photograph and shows the same person. Both photographs are
in the public domain.

{pictures.markdown()}
"""
