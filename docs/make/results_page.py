"""The page docs/results.md, of what make_results.py measured."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import results_pictures as pictures
from makeup_video.pipeline.reference.crops import NUMBERS
from makeup_video.training.reference.draw_products import COLOUR_SEEN, number_errors
from makeup_video.training.reference.evaluate import (
    KNOWN,
    MEAN,
    MEASURES,
    SOURCE,
    TRUE,
    Measured,
    colour_error,
    gloss_rank,
)
from makeup_video.training.reference.picture_metrics import FACE_PX
from makeup_video.training.reference.read_look import Cost
from makeup_video.training.reference.rendered_crops import TEST_QUALITY

PAGE = Path(__file__).parents[1] / "results.md"
JUDGEMENT = "## What still goes wrong"
# What we set out to reach: CIEDE2000 median and 90th percentile, of 255, rank correlation
REACH_CIEDE = {"lips": (2.5, 6.0), "eyes": (3.0, 7.0)}
REACH_COLOUR, REACH_GLOSS = 12.0, 0.8
# The paper's lipstick net: its own names of the numbers in a table of its LaTeX source (Kips et
# al., 2021, supplement, commented out); and table 1, on the photographed triplets of CA-GAN.
PAPER_MAE = {"red": "28.25", "green": "89.93", "blue": "83.64", "gloss": "0.29 (wetness, 0 to 1)",
             "gloss_roughness": "0.29 (glossDetail)"}  # fmt: skip
PAPER_TRIPLETS = {"BeautyGAN": (0.123, 0.371, 0.093), "CA-GAN": (0.085, 0.304, 0.077),
                  "the paper": (0.083, 0.283, 0.060)}  # fmt: skip
_RANGES = {"red": "0 to 255", "green": "0 to 255", "blue": "0 to 255", "gloss": "0 to 4"}
_METHODS = {TRUE: "the true numbers (the best that can be)", MEAN: "mean colour moved",
            SOURCE: "source left as it is"}  # fmt: skip
_UNMEASURED, MISSED = "not measured", "**missed**"


@dataclass(frozen=True, eq=False)
class Results:
    """main: by what is worn.  extremes, tones, more: by region, then by colour or tone.

    nets: their names; the first is that of all else.  costs: by net and region.
    """

    main: Mapping[str, Measured]
    extremes: Mapping[str, Mapping[str, Measured]]
    tones: Mapping[str, Mapping[str, Measured]]
    more: Mapping[str, Mapping[str, Measured]]
    nets: Sequence[str]
    costs: Mapping[str, Mapping[str, Cost]]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)


def number(value: float, digits: int = 3) -> str:
    return _UNMEASURED if np.isnan(value) else f"{value:.{digits}f}"


def median_and_most(off: np.ndarray) -> tuple[float, float]:
    median, most = np.quantile(off, (0.5, 0.9)).tolist()
    return median, most


def reach(results: Results) -> str:
    """What we set out to reach beside what was measured, misses first."""
    rows = []
    for region in REACH_CIEDE:
        for what, limit, measured, met in _reach_of(results.main[region], results.nets[0], region):
            rows.append((f"{region}: {what}", limit, measured, "reached" if met else MISSED))
    return table(("", "reach", "measured", ""), sorted(rows, key=lambda row: row[3] != MISSED))


def _reach_of(found: Measured, ours: str, region: str) -> Iterator[tuple[str, str, str, bool]]:
    """What, its limit, what was measured, whether that is within."""
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
    return table(("", "range", "lips", "eyes", "the paper, lips"), rows)


def known_line(results: Results) -> str:
    """How much finding the face and reading its light in the made-up photo costs."""
    parts = []
    for region in REACH_CIEDE:
        found = results.main[region]
        end, known = (colour_error(*found.pair(name, region)) for name in (results.nets[0], KNOWN))
        parts.append(f"{region} {number(known, 2)} in place of {number(end, 2)}")
    lost = sum(found.unread for found in results.main.values())
    count = sum(len(found.tone) for found in results.main.values())
    return (
        "Points and light are found in the made-up photo itself. With those of the bare portrait the mean error of colours\n"
        f"would be: {'; '.join(parts)}. In {lost} of {count} photos no face was found."
    )


def triplet_tables(results: Results) -> str:
    """One table for each of what is worn."""
    parts = []
    for worn, found in results.main.items():
        methods = {results.nets[0]: "**ours**", **_METHODS}
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
        parts.append(table(head, rows))
    return "\n\n".join(parts)


def by_kind(ours: str, kinds: Mapping[str, Mapping[str, Measured]], what: str) -> str:
    """A row for each region and colour or tone; of tones only the makeup is compared."""
    whole, rows = MEASURES[1:] if what == "colour" else (), []
    for region, by_name in kinds.items():
        for name, found in by_name.items():
            people = f"{len(np.unique(found.person))}, {len(found.tone)}"
            off = *median_and_most(found.only(ours)), float(np.median(found.only(MEAN)))
            error = colour_error(*found.pair(ours, region))
            rest = (number(found.only(ours, measure).mean(), 5) for measure in whole)
            rows.append((region, name, people, *(f"{x:.2f}" for x in off), number(error, 1), *rest))
    head = ("", what, "people, looks", "CIEDE2000, median", "90 %", "median of mean colour moved")
    return table((*head, "colour, of 255", *whole), rows)


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
    return table((*head, "colour, of 255", "gloss, rank", *MEASURES[1:]), rows)


def text(results: Results) -> str:
    """The page, down to the judgement."""
    parts = (_beginning, _triplets, _kinds, _end)
    return "\n".join(part(results) for part in parts) + f"\n{JUDGEMENT}\n"


def _beginning(results: Results) -> str:
    return f"""# Results: how well a look is read from one photo

Made by `python docs/make/make_results.py`, which measures everything on this page. The people and the products are unseen:
no net was trained on them. Looks are painted by the renderer with all of its 17 numbers, those that no net tells too; photos
are saved as JPEG {TEST_QUALITY}, and from such a photo alone a look is read, as the product does it: find the face, read the
light, cut the crop, seven numbers, the renderer's other settings from the nearest finish. People are drawn so that
skin tones come about as often, as far as there are some.

## Reach

CIEDE2000: the look that was read and the true one, painted on the same other bare person, over the px that are made up.

{reach(results)}

## Error of each number

Mean of |error|; that of colours where opacity is at least {COLOUR_SEEN:g}: of less, little can be told. The paper's figures
are in a table of its source that was commented out. Its numbers are defined a little differently, and one more (gamma,
1.42, of any positive value) has no counterpart here.

{numbers_table(results)}

{known_line(results)}
"""


def _triplets(results: Results) -> str:
    return f"""## Triplets

A photo of somebody who wears the look, somebody else who is bare, and that one with the same look as the truth. Those who
wear looks and those who are bare are different halves of the test people. L1, MS-SSIM (of R'G'B') and LPIPS are of the
whole face at {FACE_PX} x {FACE_PX} px, values 0 to 1, so the makeup is a small part of them.

The paper's figures (its table 1, lipstick) are from other, photographed triplets, in which the two photos of a person
differ in more than makeup. They can be compared with each other, not with ours.

*Mean colour moved* is what a simple tool does: the mean Lab of the region becomes that of the reference, its detail stays.

{triplet_tables(results)}
"""


def _kinds(results: Results) -> str:
    ours = results.nets[0]
    more = f"""
Real photographs, of people and in light that neither the nets nor the renderer were made by; those who look made up were
left out. Tone is that of the cheeks in the photo, so a shadow or a coloured lamp counts as well.

{by_kind(ours, results.more, "tone")}
""" if results.more else ""  # fmt: skip
    return f"""## Extreme colours

Blue, green, black, white and yellow products, opacity 0.6 to 1, otherwise as real ones.

{by_kind(ours, results.extremes, "colour")}

## Skin tones

By the tone of who wears the look (individual typology angle of the cheeks), people of the validation and test parts; the
validation people were watched during training, never trained on. Mind how few people some rows have.

{by_kind(ours, results.tones, "tone")}
{more}"""


def _end(results: Results) -> str:
    return f"""## Nets

Size of the weights and time of one crop; the rest as above, on the same triplets.

{nets_table(results)}

## Pictures

A look is painted on a reference, read from that photo saved as JPEG {TEST_QUALITY}, and painted on another picture, beside
the truth. Lipsticks go from Grace Hopper to Eileen Collins. Hopper's lids are behind the rims of her glasses, so eye-shadow
goes from the photograph of Collins to a frame of `samples/in.mp4`, made from that photograph: the same person. Both
photographs are in the public domain.

{pictures.markdown()}
"""


def kept_judgement(path: Path = PAGE) -> str:
    """What a page says under its last heading."""
    if not path.exists():
        return ""
    return path.read_text(encoding="utf-8").partition(JUDGEMENT + "\n")[2]
