"""Write the measured parts of docs/measurements.md, its tables and plots, from stored results."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import contact_sheet as sheet
from makeup_video.benchmark.plots import legend_below, new_figure, save
from makeup_video.benchmark.tables import tables

DOCS = Path(__file__).parents[1]
PAGE = DOCS / "measurements.md"
FOLDER = DOCS / "pictures"
PICTURES = tuple(f"performance_{name}.png" for name in ("resolution", "faces", "length"))

_BARE, _OURS, _MORE = "#9aa5b1", "#b4002e", "#5b8db8"
# The goals: label, how to read the value from the results of a size, at least or at most, and the
# limits by size.
_Read = Callable[[Mapping[str, Any]], float]
GOALS: tuple[tuple[str, _Read, str, Mapping[str, float]], ...] = (
    (
        "whole product / bare, frames/s",
        lambda row: row["product"]["ratio"], ">=",
        {"720p": 0.78, "1080p": 0.85, "2160p": 0.92},
    ),
    (
        "all but the codec, CPU ms a frame",
        lambda row: row["product"]["not_codec_cpu_ms"], "<=",
        {"720p": 4, "1080p": 5.5, "2160p": 9},
    ),
    (
        "times real time, default preset",
        lambda row: row["default_times_real_time"], ">=", {"720p": 2.5, "1080p": 1.2},
    ),
    ("peak memory, MB", lambda row: row["peak_memory_mb"], "<=", {"1080p": 450}),
    ("start to first packet, s", lambda row: row["start_seconds"], "<=",
     {"720p": 0.8, "1080p": 0.8, "2160p": 0.8}),
    ("frames painted", lambda row: row["painted_share"], ">=",
     {"720p": 0.95, "1080p": 0.95, "2160p": 0.95}),
)  # fmt: skip


def write_page(measured: Mapping[str, Any], page: Path, folder: Path) -> None:
    """Write each measured part between its markers in the page, and its plot into the folder.

    The rest of the page stays. Raises ValueError when the page lacks the markers of a
    part.
    """
    text = page.read_text(encoding="utf-8")
    for part, values in measured.items():
        text = between_markers(text, part, PARTS[part](values, folder))
    page.write_text(text, encoding="utf-8")


def between_markers(page: str, part: str, text: str) -> str:
    """Replace the text between the markers of a part. Raises ValueError when there are none."""
    markers = re.compile(rf"(<!-- measured: {part} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not markers.search(page):
        raise ValueError(f"the page has no <!-- measured: {part} --> ... <!-- end -->: add them")
    return markers.sub(lambda found: f"{found[1]}\n{text.strip()}\n\n{found[2]}", page)


def _whole(clips: Mapping[str, Mapping[str, Any]], folder: Path) -> str:
    """Return the tables of every clip.

    clips: the output of `makeup-video bench --json` by name.
    """
    parts = []
    for results in clips.values():
        sizes = list(results["sizes"])
        options = f"--sizes {','.join(sizes)} --rounds {results['rounds']}"
        command = f"    makeup-video bench CLIP {options}\n"
        parts += [f"### {results['clip']}\n", command, _goals(results["sizes"])]
        parts += [_titled(*found) for found in tables(results)]
    return "\n".join(parts)


def _goals(sizes: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for label, read, sign, limits in GOALS:
        cells = [_with_limit(read(row), sign, limits.get(name)) for name, row in sizes.items()]
        rows.append((label, *cells))
    return sheet.table(("measured (goal)", *sizes), rows) + "\n"


def _with_limit(value: float, sign: str, limit: float | None) -> str:
    shown = f"{value:.0f}" if value >= 100 else f"{value:.3g}"
    if limit is None:
        return shown
    reached = value >= limit if sign == ">=" else value <= limit
    return f"{shown} ({sign} {limit:g}{'' if reached else ': missed'})"


def _resolution(values: Mapping[str, Any], folder: Path) -> str:
    rows = values["heights"]
    mpx = [row["px"] / 1e6 for row in rows.values()]
    figure, (cost, speed) = new_figure(2)
    for kind, colour, label in (("bare", _BARE, "bare"), ("product", _OURS, "whole product")):
        y = [row[kind]["cpu_ms_per_frame"] for row in rows.values()]
        cost.plot(mpx, y, "o-", color=colour, label=label)
    y = [row["product"]["not_codec_cpu_ms"] for row in rows.values()]
    cost.plot(mpx, y, "o-", color=_MORE, label="not codec")
    cost.set_ylabel("CPU ms a frame")
    cost.set_ylim(0)
    speed.plot(mpx, [row["product"]["ratio"] for row in rows.values()], "o-", color=_OURS,
               label="whole product / bare")  # fmt: skip
    speed.set_ylim(0, 1.05)
    speed.set_ylabel("ratio of frames/s")
    _finish(figure, (cost, speed), "Mpx of a frame", folder / PICTURES[0])
    lines = [
        (
            name,
            f"{row['bare']['fps']:.1f}",
            f"{row['product']['fps']:.1f}",
            f"{row['product']['ratio']:.3f}",
            f"{row['bare']['cpu_ms_per_frame']:.2f}",
            f"{row['product']['not_codec_cpu_ms']:.2f}",
        )
        for name, row in rows.items()
    ]
    head = ("", "bare, frames/s", "product, frames/s", "ratio", "bare, CPU ms", "not codec, CPU ms")
    return _shown(PICTURES[0], "Cost by resolution") + sheet.table(head, lines) + "\n"


def _faces(values: Mapping[str, Any], folder: Path) -> str:
    rows = values["counts"]
    counts = [int(count) for count in rows]
    figure, (cost, speed) = new_figure(2)
    y = [row["not_codec_cpu_ms"] for row in rows.values()]
    cost.plot(counts, y, "o-", color=_OURS, label="not codec, CPU ms a frame")
    cost.set_ylabel("CPU ms a frame")
    cost.set_ylim(0)
    speed.plot(counts, [row["fps"] for row in rows.values()], "o-", color=_OURS,
               label="whole product")  # fmt: skip
    speed.set_ylabel("frames/s")
    speed.set_ylim(0)
    _finish(figure, (cost, speed), "faces", folder / PICTURES[1])
    ((title, *table),) = tables({"sizes": {}, "faces": values})
    return _shown(PICTURES[1], "Cost by faces") + _titled(title, *table)


def _length(runs: Sequence[Mapping[str, Any]], folder: Path) -> str:
    figure, (speed, memory) = new_figure(2)
    minutes = [run["minutes"] for run in runs]
    speed.semilogx(minutes, [run["fps"] for run in runs], "o-", color=_OURS, label="frames/s")
    speed.set_ylim(0)
    speed.set_ylabel("frames/s, without the start")
    longest = max(runs, key=lambda run: run["minutes"])
    seconds, size_mb = zip(*longest["memory"], strict=True)
    label = f"a video of {longest['minutes']:.3g} minutes"
    done_minutes = [longest["minutes"] * second / seconds[-1] for second in seconds]
    memory.plot(done_minutes, size_mb, color=_OURS, label=label)
    memory.set_ylim(0)
    memory.set_ylabel("memory, MB")
    _finish(figure, (speed, memory), "minutes of video", folder / PICTURES[2])
    rows = [
        (
            f"{run['minutes']:.3g}",
            str(run["frames"]),
            f"{run['fps']:.1f}",
            f"{run['peak_memory_mb']:.0f}",
            f"{run['growth']:.3f}",
        )
        for run in runs
    ]
    head = ("minutes", "frames", "frames/s", "peak memory, MB", "memory, last tenth / third tenth")
    return _shown(PICTURES[2], "Cost by length") + sheet.table(head, rows) + "\n"


def _threads(values: Mapping[str, Any], folder: Path) -> str:
    ((title, *table),) = tables({"sizes": {}, "threads": values})
    return _titled(title, *table)


def _peer(text: str, folder: Path) -> str:
    return text


PARTS: Mapping[str, Callable[[Any, Path], str]] = {
    "whole": _whole,
    "resolution": _resolution,
    "faces": _faces,
    "threads": _threads,
    "length": _length,
    "peer": _peer,
}


def _finish(figure: Any, axes: Iterable[Any], x_label: str, target: Path) -> None:
    for axis in axes:
        axis.set_xlabel(x_label)
        legend_below(axis, 0.18)
    save(figure, target)


def _titled(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return f"{title}:\n\n{sheet.table(head, rows)}\n"


def _shown(picture: str, description: str) -> str:
    return f"![{description}](pictures/{picture})\n\n"
