"""The results of `makeup-video bench` as tables."""

import io
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

Row = tuple[str, ...]
_Values = Mapping[str, Any]

_STAGE_HEAD = ("", "wall time: mean", "p50", "p95", "own CPU time: mean", "p50", "frames waiting")
_STAGE_KEYS = ("mean_ms", "p50_ms", "p95_ms", "cpu_mean_ms", "cpu_p50_ms")


def draw_tables(results: _Values, text: io.StringIO) -> None:
    """Draw everything that was measured; for two versions, add a line for each size."""
    from rich.console import Console
    from rich.table import Table

    console = Console(file=text)
    for title, head, rows in tables(results):
        table = Table(*head, title=title, title_justify="left")
        for row in rows:
            table.add_row(*row)
        console.print(table)
    text.writelines(f"{line}\n" for line in verdicts(results))


def tables(results: _Values) -> Iterator[tuple[str, Row, list[Row]]]:
    """Title, column heads and rows of every table."""
    if "against" in results:
        yield from _versions(results["against"])
    if "live" in results:
        yield from live_tables(results["live"]["sizes"])
    sizes: Mapping[str, _Values] = results.get("sizes", {})
    if sizes:
        yield _title(results), ("", *sizes), list(_by_size(sizes.values()))
    for name, size in sizes.items():
        yield f"{name}: ms a frame", _STAGE_HEAD, list(_stages(size))
    if any("renderer" in size for size in sizes.values()):
        yield "painting with everything on, CPU ms a frame", ("", *sizes), list(_renderer(sizes))
        title = "theoretical minimum (floor), CPU ms a frame"
        yield title, ("", *sizes), list(_floor(sizes))
    yield from more_tables(results)


def _versions(found: _Values) -> Iterator[tuple[str, Row, list[Row]]]:
    """The tables that compare this version with another."""
    head = ("", f"this, {found['this']}", f"other, {found['other']}", "this / other")
    measures = (
        ("CPU ms a frame", "cpu_ms_per_frame", "cpu", ".2f"),
        ("stages without the codec, CPU ms a frame", "stages_ms", "stages", ".2f"),
        ("frames/s; ratio of wall times", "fps", "wall", ".1f"),
        ("start to first packet, s", "start_seconds", "start", ".2f"),
        ("peak memory, MB", "peak_memory_mb", "memory", ".0f"),
    )
    for size in found["sizes"].values():
        rows = [
            (label, *(_known(size[side][key], shape) for side in ("this", "other")),
             _ratio(size[ratio]))
            for label, key, ratio, shape in measures
        ]  # fmt: skip
        rows += [
            (f"{name}, CPU ms a frame", f"{stage['this']:.2f}", f"{stage['other']:.2f}",
             _ratio(stage))
            for name, stage in size["by_stage"].items()
        ]  # fmt: skip
        yield f"{found['clip']}, {size['film']}, {found['codec']}", head, rows


def _known(value: float | None, shape: str) -> str:
    return "unknown" if value is None else f"{value:{shape}}"


def _ratio(found: _Values | None) -> str:
    """A median and its spread: "0.93 (0.91-0.96)"."""
    if found is None:
        return "unknown"
    low, high = found["spread"]
    return f"{found['ratio']:.2f} ({low:.2f}-{high:.2f})"


def verdicts(results: _Values) -> Iterator[str]:
    """A line for each size on which two versions were compared."""
    if "against" in results:
        found = results["against"]
        for name, size in found["sizes"].items():
            yield (
                f"this version takes {_ratio(size['cpu'])} of the CPU time of {found['other']} at "
                f"{name}, and {_ratio(size['wall'])} of its wall time"
            )


def live_tables(sizes: Mapping[str, _Values]) -> Iterator[tuple[str, Row, list[Row]]]:
    """The figures of the live run, and where the time goes."""
    warm = next(iter(sizes.values()))["warm_up_seconds"]
    title = f"live, from a frame's arrival to its picture on a page; without the first {warm:g} s"
    yield title, ("", *sizes), list(_live(list(sizes.values())))
    for name, size in sizes.items():
        rows = [
            (way, *(f"{ms:.1f}" for ms in spread.values()))
            for way, spread in size["ways_ms"].items()
        ]
        yield f"{name}: where the time goes, ms", ("", "p50", "p95", "p99", "max"), rows


def _live(rows: list[_Values]) -> Iterator[Row]:
    def spread(ms: _Values) -> str:
        return " / ".join(f"{ms[key]:.1f}" for key in ("p50", "p95", "p99") if key in ms)

    yield _row("video", rows, lambda r: r["film"])
    yield _row("seconds / frames", rows, lambda r: f"{r['seconds']:.0f} / {r['frames']}")
    yield _row("latency, ms: p50 / p95 / p99", rows, lambda r: spread(r["latency_ms"]))
    yield _row(
        "until decoded; in Chromium drawn, ms", rows, lambda r: spread(r["decoded_latency_ms"])
    )
    yield _row("the start, not counted", rows, lambda r: spread(r["warm_up_latency_ms"]))
    yield _row("first 10 s", rows, lambda r: spread(r["first_seconds_latency_ms"]))
    yield _row("last 10 s", rows, lambda r: spread(r["last_seconds_latency_ms"]))
    yield _row("dropped by the camera's file", rows, lambda r: str(r["dropped_by_camera"]))
    yield _row("dropped before painting", rows, lambda r: str(r["dropped_before_painting"]))
    yield _row("dropped in the preview", rows, lambda r: str(r["dropped_in_preview"]))
    yield _row("frames painted", rows, lambda r: f"{100 * r['painted_share']:.1f} %")
    yield _row("pictures/s", rows, lambda r: f"{r['fps']:.2f}")
    yield _row("kB a picture", rows, lambda r: f"{r['bytes_per_picture'] / 1000:.1f}")
    yield _row("Mbit/s", rows, lambda r: f"{8e-6 * r['bytes_per_picture'] * r['fps']:.2f}")
    yield _row("CPU ms a frame", rows, lambda r: f"{r['cpu_ms_per_frame']:.1f}")
    yield _row("cores busy", rows, lambda r: f"{r['cpu_cores']:.2f}")
    yield _row(
        "CPU ms a frame of the viewer", rows, lambda r: f"{r['viewer_cpu_ms_per_frame']:.1f}"
    )
    for when, label in (("after_10_s", "after 10 s"), ("at_end", "at the end")):
        sizes_mb = [r["memory_mb"][when] for r in rows]
        yield _row(
            f"memory {label}, MB", sizes_mb, lambda mb: "unknown" if mb is None else f"{mb:.0f}"
        )
    yield _row("quality level at the end", rows, lambda r: str(r["level"]))


def _title(results: _Values) -> str:
    rounds = results["rounds"]
    many = f"medians of {rounds} rounds" if rounds > 1 else "one round"
    return f"{results['clip']}, {results['codec']}, {many}"


def _row(label: str, values: Iterable[Any], text_of: Callable[[Any], str]) -> Row:
    return (label, *(text_of(value) for value in values))


def _by_size(sizes: Iterable[_Values]) -> Iterator[Row]:
    rows = list(sizes)
    of = {kind: [row[kind] for row in rows] for kind in ("bare", "codec", "none", "product")}

    def fps(run: _Values) -> str:
        return f"{run['fps']:.1f} ({run['fps_spread'][0]:.0f} to {run['fps_spread'][1]:.0f})"

    def ratio(run: _Values) -> str:
        return f"{run['ratio']:.3f} ({run['ratio_spread'][0]:.2f} to {run['ratio_spread'][1]:.2f})"

    yield _row("video", rows, lambda r: r["film"])
    yield _row("bare decode+encode, frames/s", of["bare"], fps)
    yield _row("bare: threads of decoder + encoder", of["bare"], _threads_of)
    yield _row("--look none, frames/s", of["none"], fps)
    yield _row("whole product, frames/s", of["product"], fps)
    yield _row("--look none / bare", of["none"], ratio)
    yield _row("whole product / bare", of["product"], ratio)
    yield _row(
        "times real time, default preset", rows, lambda r: f"{r['default_times_real_time']:.2f}"
    )
    for kind, label in (
        ("bare", "bare"),
        ("codec", "bare with the product's threads"),
        ("none", "--look none"),
        ("product", "whole product"),
    ):
        yield _row(f"{label}, CPU ms", of[kind], lambda run: f"{run['cpu_ms_per_frame']:.2f}")
    yield _row(
        "not codec, CPU ms",
        of["product"],
        lambda p: f"{p['not_codec_cpu_ms']:.2f}",
    )
    yield _row("frames painted", rows, lambda r: f"{100 * r['painted_share']:.1f} %")
    yield _row("start to first packet, s", rows, lambda r: f"{r['start_seconds']:.2f}")
    yield _row("cold start, s", rows, lambda r: f"{r['first_start_seconds']:.2f}")
    yield _row("peak memory, MB", rows, lambda r: f"{r['peak_memory_mb']:.0f}")
    yield _row("bottleneck", rows, lambda r: r["bottleneck"])


def _threads_of(bare: _Values) -> str:
    return " + ".join(str(count or "auto") for count in bare["threads"])


def _stages(size: _Values) -> Iterator[Row]:
    for name, times in size["stages"].items():
        channel = size["channels"].get(f"-> {name}")
        fill = f"{channel['mean_fill']:.2f} of {channel['capacity']:g}" if channel else ""
        yield (name, *(f"{times[key]:.2f}" for key in _STAGE_KEYS), fill)


def _renderer(sizes: Mapping[str, _Values]) -> Iterator[Row]:
    rows = [size["renderer"] for size in sizes.values()]
    kernels = [row["kernel"] for row in rows]
    for key, label in (
        ("scene_ms", "scene: surfaces and light"),
        ("composite_ms", "composite"),
        ("together_ms", "together, median"),
        ("together_mean_ms", "together, mean"),
    ):
        yield _row(label, [row[key] for row in rows], "{:.2f}".format)
    yield _row("of this, the kernels", kernels, lambda k: f"{k['kernel_ms']:.2f}")
    label = "launches / work-items / px painted"
    shape = "{launches:.0f} / {work_items:.0f} / {painted_px:.0f}"
    yield _row(label, kernels, lambda k: shape.format(**k))
    label = "a look of every kind, times together"
    yield _row(label, [row["whole_look"] for row in rows], "{:.2f}".format)


def _floor(sizes: Mapping[str, _Values]) -> Iterator[Row]:
    rows = [size["floor"] for size in sizes.values()]
    for key, label in (
        ("decode_ms", "decoding, one thread"),
        ("encode_ms", "encoding, one thread"),
        ("copy_ms", "copying the painted px once"),
        ("paint_ms", "arithmetic of painting"),
        ("nets_ms", "arithmetic of the nets"),
        ("least_ms", "floor, all but the codec"),
    ):
        yield _row(label, [row[key] for row in rows], "{:.3g}".format)
    measured = [size["product"]["not_codec_cpu_ms"] for size in sizes.values()]
    yield _row("measured, all but the codec", measured, "{:.2f}".format)
    yield _row(
        "measured / floor", [size["times_the_floor"] for size in sizes.values()], "{:.1f}".format
    )


def more_tables(results: _Values) -> Iterator[tuple[str, Row, list[Row]]]:
    """The tables of faces, threads, looks and length; only those that were asked for."""
    if "faces" in results:
        faces = results["faces"]
        title = (
            f"{faces['height_px']}p frames with several faces; "
            f"each further face costs {faces['further_face_cpu_ms']:.2f} CPU ms"
        )
        yield (
            title,
            ("faces", "frames/s", "ratio to bare", "not codec, CPU ms"),
            list(_faces(faces)),
        )
    if "threads" in results:
        threads = results["threads"]
        title = f"threads, {threads['size']}; best: {threads['best']}"
        yield title, ("", "frames/s", "CPU ms a frame"), list(_threads(threads))
    if "looks" in results:
        found = results["looks"]
        title = f"{found['looks']} looks of one video, {found['size']}"
        yield title, ("", "measured"), list(_looks(found))
    if "length" in results:
        run = results["length"]
        shape = "{minutes:.1f} {fps:.1f} {peak_memory_mb:.0f} {growth:.3f}"
        head = ("minutes of video", "frames/s", "peak memory, MB", "memory, end / beginning")
        yield f"a long video, {run['size']}", head, [tuple(shape.format(**run).split())]


def _looks(found: _Values) -> Iterator[Row]:
    memory = found["memory_mb"]
    yield from (
        ("painting and encoding one look, CPU ms a frame", f"{found['own_cpu_ms']:.2f}"),
        ("each further look of a run, CPU ms a frame", f"{found['further_cpu_ms']:.2f}"),
        ("each further look / painting and encoding one", f"{found['further_by_own']:.2f}"),
        ("one run, s", f"{found['seconds']['many']:.1f}"),
        ("separate runs, s", f"{found['seconds']['separate']:.1f}"),
        ("one run / separate runs", f"{found['many_by_separate']:.2f}"),
        ("peak memory of one look, MB", f"{memory['one']:.0f}"),
        ("each further look, MB", f"{memory['further']:.0f}"),
        ("a second encoder of a bare loop, MB", f"{memory['encoder']:.0f}"),
    )


def _faces(faces: _Values) -> Iterator[Row]:
    for count, run in faces["counts"].items():
        yield count, f"{run['fps']:.1f}", f"{run['ratio']:.3f}", f"{run['not_codec_cpu_ms']:.2f}"


def _threads(threads: _Values) -> Iterator[Row]:
    for name, run in threads["settings"].items():
        yield name, f"{run['fps']:.1f}", f"{run['cpu_ms_per_frame']:.2f}"
