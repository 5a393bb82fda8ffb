"""The options of `apply` and `batch` that say how outputs are written."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.look_options import Changes
from makeup_video.cli.options import OUTPUT, End, Start, parse_time

if TYPE_CHECKING:
    from makeup_video.pipeline import Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputOptions:
    """How outputs are written, as typed."""

    compare: Annotated[
        bool,
        typer.Option(
            "--compare", help="Show before and after side by side.", rich_help_panel=OUTPUT
        ),
    ] = False
    start: Start = None
    end: End = None
    codec: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="{codecs}; default: what suits IN and OUT.",
            rich_help_panel=OUTPUT,
        ),
    ] = None
    crf: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Quality: a lower number gives better quality and a larger file; default: by "
            "codec.",
            rich_help_panel=OUTPUT,
        ),
    ] = None
    preset: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="The encoder's speed preset; default: by codec.",
            rich_help_panel=OUTPUT,
        ),
    ] = None
    hardware: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Use a hardware encoder: {hardware}, or auto for the first that works.",
            rich_help_panel=OUTPUT,
        ),
    ] = "none"
    bit_depth: Annotated[
        int | None,
        typer.Option(
            metavar="BITS",
            help="8, 10 or 12; default: that of IN, but 8 in H.264.",
            rich_help_panel=OUTPUT,
        ),
    ] = None
    sdr: Annotated[
        bool,
        typer.Option(
            "--sdr", help="Turn HDR (PQ, HLG) into SDR, for every screen.", rich_help_panel=OUTPUT
        ),
    ] = False
    strict: Annotated[
        bool,
        typer.Option(
            "--strict",
            help="Fail instead of dropping or converting anything that you did not ask for.",
            rich_help_panel=OUTPUT,
        ),
    ] = False

    def settings(
        self,
        look: Changes,
        *,
        overwrite: bool,
        split: float | None = None,
        jobs: int | None = None,
        on_whole: "Callable[[], None] | None" = None,
    ) -> "Settings":
        """The settings of a run.

        look: the options that name faces and device.  split: minutes of a segment.  jobs: how many
        segments are painted at once.  Raises UsageError.
        """
        from makeup_video.pipeline import Settings

        return Settings(
            codec=self.codec,
            crf=self.crf,
            preset=self.preset,
            hardware=self.hardware,
            start_seconds=parse_time(self.start, "--start"),
            end_seconds=parse_time(self.end, "--end"),
            overwrite=overwrite,
            strict=self.strict,
            bit_depth=self.bit_depth,
            sdr=self.sdr,
            faces=look.faces,
            compare=self.compare,
            split_minutes=split,  # type: ignore[arg-type]  # Settings makes it an exact fraction
            jobs=jobs,
            device=look.device,
            on_whole=on_whole,
        )
