"""`makeup-video IN --color '#B4002E' -o OUT`: the main job."""

from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.look_options import (
    Color,
    Faces,
    Finish,
    Intensity,
    LookFile,
    OpenclDevice,
    Parts,
    RefFace,
    RefPhoto,
    Strength,
    Zone,
    base_look,
    parse_time,
)
from makeup_video.cli.outcome import tell, told_in_one_line
from makeup_video.pipeline.media.codecs import codecs_with

if TYPE_CHECKING:
    from makeup_video.pipeline.media.sidecar import JsonFile


def apply(
    source: Annotated[str, typer.Argument(metavar="IN", help="A video or a picture.")],
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="OUT", help="Where to write the result.")
    ],
    look: LookFile = None,
    color: Color = None,
    finish: Finish = None,
    parts: Parts = None,
    zone: Zone = None,
    intensity: Intensity = None,
    strength: Strength = None,
    faces: Faces = "all",
    compare: Annotated[
        bool, typer.Option("--compare", help="Show before and after beside each other.")
    ] = False,
    device: OpenclDevice = "",
    save_look: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write the look that is painted as JSON.")
    ] = None,
    ref: RefPhoto = None,
    ref_face: RefFace = None,
    codec: Annotated[
        str | None,
        typer.Option(help=f"{codecs_with(lambda codec: True)}; default: what suits IN and OUT."),
    ] = None,
    crf: Annotated[
        int | None, typer.Option(help="Quality: lower is better and larger; default by codec.")
    ] = None,
    preset: Annotated[
        str | None, typer.Option(help="The encoder's speed preset; default by codec.")
    ] = None,
    bit_depth: Annotated[
        int | None,
        typer.Option(metavar="BITS", help="8, 10 or 12; default: as IN has, but 8 in H.264."),
    ] = None,
    sdr: Annotated[
        bool, typer.Option("--sdr", help="Turn HDR (PQ, HLG) into SDR, for every screen.")
    ] = False,
    start: Annotated[
        str | None, typer.Option(help="Begin here: seconds, or [hh:]mm:ss[.fraction].")
    ] = None,
    end: Annotated[
        str | None, typer.Option(help="End here, counted from the same beginning.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("-y", "--yes", help="Overwrite what exists: OUT and side files.")
    ] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail rather than drop or convert anything unasked.")
    ] = False,
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write counts and times as JSON.")
    ] = None,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Paint a look on every frame of IN and write OUT (the command to run without a name)."""
    # the pipeline takes a third of a second to import: not for --help
    from makeup_video.cli.main import nothing_is_left_to_stop
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import Settings, process_video
    from makeup_video.pipeline.look.options import Choice, check_options, choose_look

    with told_in_one_line(output, debug):
        settings = Settings(
            codec=codec,
            crf=crf,
            preset=preset,
            start_seconds=None if start is None else parse_time(start, "--start"),
            end_seconds=None if end is None else parse_time(end, "--end"),
            overwrite=overwrite,
            strict=strict,
            bit_depth=bit_depth,
            sdr=sdr,
            faces=faces,
            compare=compare,
            device=device,
            on_whole=nothing_is_left_to_stop,
        )
        chosen = Choice(
            color=color,
            finish=finish,
            parts=parts,
            zone=zone,
            intensity=intensity,
            strength=strength,
        )
        check_options(chosen)
        read = [file for file in (None if look == "none" else look, ref) if file is not None]
        with _side_files(source, output, read, report, save_look, overwrite) as files:
            base = base_look(look, ref, ref_face, color, quiet)
            painted = choose_look(replace(chosen, base=base))
            with show_progress(quiet) as on_progress:
                done = process_video(source, output, painted, settings, on_progress)
            for file, values in zip(files, (done.to_dict(), painted.to_dict()), strict=True):
                if file is not None:
                    file.write(values)
    tell(done, quiet)


@contextmanager
def _side_files(
    source: str,
    output: str,
    read: list[str],
    report: str | None,
    save_look: str | None,
    overwrite: bool,
) -> "Generator[tuple[JsonFile | None, JsonFile | None], None, None]":
    """The report and the look, both checked, and OUT too, before either is begun; read: more of our
    inputs."""
    from makeup_video.pipeline.files.output_file import check_place, keep_apart
    from makeup_video.pipeline.media.input_file import local_file
    from makeup_video.pipeline.media.sidecar import LookFile, ReportFile

    check_place(output, local_file(source), overwrite=overwrite)
    for file in read:
        keep_apart(Path(output), Path(file))
    with ExitStack() as stack:

        def opened(
            kind: "type[JsonFile]", path: str | None, other: str | None
        ) -> "JsonFile | None":
            if path is None:
                return None
            others = read if other is None else [*read, other]
            return stack.enter_context(kind(path, source, output, *others, overwrite=overwrite))

        yield opened(ReportFile, report, save_look), opened(LookFile, save_look, report)
