"""The time of each stage per frame, as in Table 3 of the paper, and the bottleneck."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from itertools import takewhile
from statistics import mean, median
from typing import Any

import numpy as np

SKIPPED, COUNTED = 100, 500  # frames: the paper skips the first 100 and averages 500
_EMPTY = 0.25  # share of a channel's capacity; below it, the other stages wait for the source


class StageLog:
    """The observer of Settings: notes the time of each stage for each item, run by run."""

    def __init__(self) -> None:
        self._runs: list[dict[str, list[tuple[float, float]]]] = []

    def start(self) -> None:
        """Note that a run begins."""
        self._runs.append(defaultdict(list))

    def __call__(self, name: str, wall_seconds: float, cpu_seconds: float) -> None:
        """Note an item. Called from the thread of the stage; each stage has a list of its own."""
        self._runs[-1][name].append((wall_seconds, cpu_seconds))

    def table(self, frames: int) -> dict[str, dict[str, float]]:
        """By stage, from decoder to encoder: ms a frame at work, and CPU ms of its own thread.

        frames: length of the clip; a short clip skips fewer frames.
        """
        skipped = min(SKIPPED, frames // 6)
        counted = slice(skipped, min(skipped + COUNTED, frames))
        table = {}
        for name in self._runs[0]:
            items = [item for run in self._runs for item in run[name][counted]]
            busy, cpu = (
                [1000 * seconds for seconds in column] for column in zip(*items, strict=True)
            )
            table[name] = {
                "mean_ms": mean(busy),
                "p50_ms": median(busy),
                "p95_ms": float(np.percentile(busy, 95)),
                "cpu_mean_ms": mean(cpu),
                "cpu_p50_ms": median(cpu),
            }
        return table


def fills(reports: Iterable[Mapping[str, Mapping[str, float]]]) -> dict[str, dict[str, float]]:
    """By channel: its capacity, and its average number of items as the median of the runs."""
    runs = list(reports)
    return {
        name: {
            "capacity": first["capacity"],
            "mean_fill": median(run[name]["mean_fill"] for run in runs),
        }
        for name, first in runs[0].items()
    }


def bottleneck(
    channels: Mapping[str, Mapping[str, float]], stages: Mapping[str, Mapping[str, Any]]
) -> str:
    """The stage that the other stages wait for.

    If all channels are nearly empty, it is the source. Otherwise it is a stage of the thread that
    the fullest channel leads to: the stage with the longest mean_ms.

    stages: from decoder to encoder, with mean_ms.  channels: "-> NAME" leads to the first stage of
    a thread.
    """
    share = {name: channel["mean_fill"] / channel["capacity"] for name, channel in channels.items()}
    fullest = max(share, key=lambda name: share[name], default="")
    order = list(stages)
    if not fullest or share[fullest] < _EMPTY:
        return order[0]
    first = order.index(fullest.removeprefix("-> "))
    heads = {name.removeprefix("-> ") for name in channels}
    others = takewhile(lambda name: name not in heads, order[first + 1 :])
    return max([order[first], *others], key=lambda name: float(stages[name]["mean_ms"]))
