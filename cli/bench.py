"""`makeup-video bench`: what the product costs beside the bare codec, in one run."""

import json
import tempfile
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import typer
from makeup_video.cli.ending import told_in_one_line
from makeup_video.cli.say import say

_SAMPLE = Path(__file__).resolve().parent.parent / "samples" / "in.mp4"
_PAINTED_ROUNDS = 5  # enough for a median of a hundred frames
_LONGER = 10  # times; memory must not grow with the length of a film


def bench(
    clip: Annotated[
        str | None, typer.Argument(metavar="CLIP", help="A video; default: our sample.")
    ] = None,
    sizes: Annotated[str, typer.Option(help="Heights to scale it to.")] = "720p,1080p",
    seconds: Annotated[float, typer.Option(help="Length of the measured clip.")] = 4.0,
    rounds: Annotated[int, typer.Option(help="How often each is run; medians count.")] = 9,
    renderer: Annotated[bool, typer.Option(help="Measure what painting a face costs.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Measure the product beside a bare decode-and-encode loop: speed, CPU, memory, start."""
    with told_in_one_line():
        results = _measure(clip, _heights(sizes), seconds, rounds)
        if renderer:
            results["renderer"] = _measure_renderer(clip, _heights(sizes), seconds, rounds)
    if as_json:
        typer.echo(json.dumps(results, indent=2))
        return
    _print_table(results)
    if renderer:
        _print_renderer(results["renderer"])


def _heights(sizes: str) -> list[int]:
    from makeup_video.pipeline import UsageError

    heights = [int(part.removesuffix("p")) for part in sizes.split(",") if _is_height(part)]
    if len(heights) != len(sizes.split(",")) or any(not 2 <= h <= 4320 for h in heights):
        raise UsageError(f"--sizes must be heights such as 720p,1080p, got {sizes!r}")
    return heights


def _is_height(text: str) -> bool:
    return text.removesuffix("p").isdecimal()


def _measure(clip: str | None, heights: list[int], seconds: float, rounds: int) -> dict[str, Any]:
    from makeup_video.cli import measure
    from makeup_video.pipeline import InputError, UsageError

    if seconds < 0.5 or rounds < 1:
        raise UsageError(f"--seconds must be at least 0.5, --rounds 1; got {seconds}, {rounds}")
    source = Path(clip) if clip else _SAMPLE
    if clip is None and not source.exists():
        raise InputError(f"the sample {source} is not installed: give a CLIP to measure with")
    results: dict[str, Any] = {
        "clip": source.name,
        "codec": f"{measure.CODEC} {measure.PRESET} crf {measure.CRF}",
        "rounds": rounds,
        "sizes": {},
    }
    with tempfile.TemporaryDirectory(prefix="makeup-video-bench-") as name:
        folder = Path(name)
        for height in heights:
            say(f"measuring {height}p ...")
            short = measure.make_clip(source, folder / "short.mp4", height, seconds)
            row = measure.compare(short, folder, rounds)
            starts = [measure.run_command(short, folder / "cold.mp4") for _ in range(3)]
            row["cold_start_seconds"] = median(run["cold_start_seconds"] for run in starts)
            row["peak_memory_mb"] = median(run["peak_memory_mb"] for run in starts)
            long = measure.make_clip(source, folder / "long.mp4", height, seconds * _LONGER)
            row["peak_memory_mb_10x"] = measure.run_command(long, folder / "l.mp4")[
                "peak_memory_mb"
            ]
            results["sizes"][f"{height}p"] = row
    return results


def _measure_renderer(
    clip: str | None, heights: list[int], seconds: float, rounds: int
) -> dict[str, Any]:
    from makeup_video.cli.measure_renderer import WARM_FRAMES, measure_renderer

    say("measuring the renderer ...")
    frames = max(round(seconds * 30), 2 * WARM_FRAMES)
    source = Path(clip) if clip else _SAMPLE
    with tempfile.TemporaryDirectory(prefix="makeup-video-bench-") as name:
        return measure_renderer(source, Path(name), heights, frames, min(rounds, _PAINTED_ROUNDS))


def _print_table(results: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    title = f"{results['clip']}, {results['codec']}, medians of {results['rounds']} rounds"
    table = Table("", *results["sizes"], title=title, title_justify="left")
    rows = results["sizes"].values()
    table.add_row("bare decode+encode, frames/s", *(f"{r['bare']['fps']:.1f}" for r in rows))
    table.add_row("--look none, frames/s", *(f"{r['none']['fps']:.1f}" for r in rows))
    table.add_row(
        "ratio (lowest..highest round)",
        *(
            f"{r['ratio']:.3f} ({min(r['ratio_spread']):.2f}..{max(r['ratio_spread']):.2f})"
            for r in rows
        ),
    )
    for name in ("bare", "none"):
        label = f"{name}, CPU ms/frame"
        table.add_row(label, *(f"{r[name]['cpu_ms_per_frame']:.2f}" for r in rows))
    table.add_row("start to first packet, s", *(f"{r['cold_start_seconds']:.2f}" for r in rows))
    table.add_row("peak memory, MB", *(f"{r['peak_memory_mb']:.0f}" for r in rows))
    label = f"peak memory, {_LONGER}x as long, MB"
    table.add_row(label, *(f"{r['peak_memory_mb_10x']:.0f}" for r in rows))
    for stage in next(iter(rows))["stages"]:
        label = f"{stage}: busy / own CPU, ms/frame"
        cells = [r["stages"][stage] for r in rows]
        table.add_row(label, *(f"{c['busy_ms']:.2f} / {c['cpu_ms']:.2f}" for c in cells))
    for channel in next(iter(rows))["channels"]:
        cells = [r["channels"][channel] for r in rows]
        label = f"channel {channel}: mean fill"
        table.add_row(label, *(f"{c['mean_fill']:.1f} of {c['capacity']}" for c in cells))
    Console().print(table)


def _print_renderer(results: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    title = "painting one face, lips and eyes, half the height of the frame: CPU ms a frame"
    table = Table("", *results["sizes"], title=title, title_justify="left")
    for name, label in (
        ("scene_ms", "scene: surfaces and light"),
        ("composite_ms", "composite"),
        ("together_ms", "together, median"),
        ("together_mean_ms", "together, mean"),
    ):
        table.add_row(label, *(f"{row[name]:.2f}" for row in results["sizes"].values()))
    kernels = [row["kernel"] for row in results["sizes"].values()]
    table.add_row("kernel alone", *(f"{k['kernel_ms']:.2f}" for k in kernels))
    table.add_row("copying its bytes", *(f"{k['copy_ms']:.3f}" for k in kernels))
    table.add_row("its arithmetic at the peak", *(f"{k['arithmetic_ms']:.3f}" for k in kernels))
    label = "px of the windows / with makeup"
    table.add_row(label, *(f"{k['window_px']} / {k['painted_px']}" for k in kernels))
    Console().print(table)
    start = results["start"]
    say(
        f"frame three times as wide and high around the same face: {results['larger_frame_ratio']:.2f}"
    )
    say(
        f"start of painting: first {start['first_seconds']:.2f} s, later {start['later_seconds']:.2f} s"
    )
