"""Turns subtitles that overlap into subtitles that are shown one at a time."""

from typing import NamedTuple

_TEXT = 8  # of an event's line as FFmpeg's decoders give it: ReadOrder, Layer, Style, ..., Text
_STYLE = 2


class Title(NamedTuple):
    """One subtitle: what is shown, and when.

    begin, end: in ticks; None: until the next one begins.
    line: an event in the format of ASS, as FFmpeg's decoders of text subtitles return it.
    """

    begin: int
    end: int | None
    line: bytes


class OneAtATime:
    """Turns titles, in the order in which they begin, into titles that do not overlap.

    While several are to be shown, one title has the lines of all, the first that began at the top.
    The times at which each text is shown do not change. A title is returned once the next one
    begins.
    """

    def __init__(self) -> None:
        self._shown: list[Title] = []
        self._since = 0

    def __call__(self, title: Title) -> list[Title]:
        """The titles that end before this one begins, or have to be shown again with it."""
        if not self._shown:
            self._since = title.begin
        begin = max(title.begin, self._since)
        done = self._until(begin)
        self._shown = [one for one in self._shown if one.end is not None or one.begin == begin]
        self._shown.append(title._replace(begin=begin))
        return done

    def drain(self) -> list[Title]:
        """The rest, once no more titles come.

        A title without an end lasts as long as the others that are still shown; where none of these
        has an end, it has no length.
        """
        ends = [one.end for one in self._shown if one.end is not None]
        if self._shown and not ends:
            return [Title(self._since, self._since, joined([one.line for one in self._shown]))]
        return self._until(max(ends, default=self._since))

    def _until(self, moment: int) -> list[Title]:
        done = []
        while self._shown:
            ends = [one.end for one in self._shown if one.end is not None]
            end = min([moment, *ends])
            if end > self._since:
                done.append(Title(self._since, end, joined([one.line for one in self._shown])))
                self._since = end
            self._shown = [one for one in self._shown if one.end is None or one.end > end]
            if end == moment:
                break
        self._since = max(self._since, moment)
        return done


def joined(lines: list[bytes]) -> bytes:
    """One event with the texts of all, below one another, each in its own style."""
    first, *rest = lines
    for line in rest:
        fields = line.split(b",", _TEXT)
        first += b"{\\r" + fields[_STYLE] + b"}\\N" + fields[_TEXT]
    return first
