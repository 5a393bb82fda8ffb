"""The results of `makeup-video bench` as a plot; needs matplotlib, the extra `plot`."""

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from makeup_video.pipeline.errors import InstallError, OutputError, UsageError, option
from makeup_video.pipeline.files.disk_errors import unwritable

_KINDS = {"bare": "#9aa5b1", "none": "#5b8db8", "product": "#b4002e"}
_NAMES = {"bare": "bare decode+encode", "none": "--look none", "product": "whole product"}
_DPI = 90


def check_plot_path(target: str) -> None:
    """Check the path and matplotlib. Raises UsageError, OutputError, InstallError."""
    path = Path(target)
    if path.suffix.lower() != ".png":
        raise UsageError(f"{option('plot')} must name a .png file, got {target!r}")
    if not path.absolute().parent.is_dir():
        raise OutputError(f"{target}: there is no folder {path.parent}: make it first")
    if find_spec("matplotlib") is None:
        raise InstallError(f"{option('plot')} needs matplotlib: pip install 'makeup-video[plot]'")


def new_figure(columns: int) -> tuple[Any, list[Any]]:
    """A figure and its `columns` axes, side by side."""
    figure = import_module("matplotlib.figure").Figure(
        figsize=(5 * columns, 3.6), dpi=_DPI, layout="constrained"
    )
    axes = list(figure.subplots(1, columns, squeeze=False)[0])
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    return figure, axes


def draw(results: Mapping[str, Any], target: Path) -> None:
    """Write a PNG: frames/s by size, and where a frame's CPU time goes. Raises OutputError."""
    sizes = results["sizes"]
    figure, (speed, cost) = new_figure(2)
    for index, (kind, colour) in enumerate(_KINDS.items()):
        rows = [size[kind] for size in sizes.values()]
        heights = [row["fps"] for row in rows]
        x = [size + 0.27 * (index - 1) for size in range(len(rows))]
        low_high = [[abs(row["fps"] - end) for row, end in zip(rows, ends, strict=True)]
                    for ends in zip(*(row["fps_spread"] for row in rows), strict=True)]  # fmt: skip
        bars = speed.bar(
            x, heights, 0.25, color=colour, label=_NAMES[kind], yerr=low_high, ecolor="#444444"
        )
        speed.bar_label(bars, fmt="%.0f", fontsize=8)
    speed.set_ylabel("frames/s: median, extremes")
    _stack(cost, {name: size["stages"] for name, size in sizes.items()})
    for axis in (speed, cost):
        axis.set_xticks(range(len(sizes)), list(sizes))
        axis.set_xlim(-0.7, len(sizes) - 0.3)
        legend_below(axis)
    figure.suptitle(f"{results['clip']}, {results['codec']}", fontsize=10)
    save(figure, target)


def _stack(axis: Any, stages: Mapping[str, Mapping[str, Mapping[str, float]]]) -> None:
    """Stack the CPU time of the stages' own threads, without the threads of the codec."""
    codec = {"decode", "encode"}
    names = [name for name in next(iter(stages.values())) if name not in codec]
    bottom = [0.0] * len(stages)
    for name in names:
        cpu_ms = [rows[name]["cpu_mean_ms"] for rows in stages.values()]
        axis.bar(range(len(cpu_ms)), cpu_ms, 0.5, bottom=bottom, label=name)
        bottom = [low + more for low, more in zip(bottom, cpu_ms, strict=True)]
    axis.set_ylabel("own CPU of each stage, ms a frame")


def legend_below(axis: Any, by: float = 0.1) -> None:
    """Put the legend below the axis, where it hides nothing.  by: a share of the axis' height."""
    axis.legend(fontsize=8, frameon=False, ncols=4, loc="upper center", bbox_to_anchor=(0.5, -by))


def save(figure: Any, target: Path) -> None:
    """Write a PNG without time or version, so that equal numbers give equal files.

    Raises OutputError.
    """
    try:
        figure.savefig(target, format="png", metadata={"Software": None})
    except OSError as error:
        raise OutputError(unwritable(target, error, "choose another place")) from error
