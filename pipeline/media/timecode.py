"""SMPTE timecode: what the first frame of an excerpt is called."""

import re
from fractions import Fraction

_TIMECODE = re.compile(r"(\d\d):([0-5]\d):([0-5]\d)([:;.])(\d\d+)")


def moved_timecode(text: str, seconds: Fraction, rate: Fraction) -> str:
    """The timecode of the frame that comes `seconds` after the one with timecode `text`.

    rate: frames per second. Timecode counts frames at the nearest whole rate. With ";" or "." (drop
    frame, SMPTE ST 12-1) it skips the first two numbers at 30 fps, or four at 60 fps, in every
    minute except each tenth; other rates have no drop frame. After 24 hours it begins anew. Text
    that is not a timecode stays as it is.
    """
    parts = _TIMECODE.fullmatch(text.strip())
    whole = round(rate)
    if parts is None or whole < 1:
        return text
    hours, minutes, second, frame = (int(parts[at]) for at in (1, 2, 3, 5))
    drops = parts[4] != ":" and whole % 30 == 0
    dropped = 2 * (whole // 30) if drops else 0  # numbers skipped in a minute
    minutes += 60 * hours
    count = (60 * minutes + second) * whole + frame - dropped * (minutes - minutes // 10)
    count = (count + round(seconds * rate)) % (1440 * 60 * whole - dropped * (1440 - 144))
    # back to timecode: tens of minutes, then minutes, of which all but the first skip numbers
    tens, rest = divmod(count, 600 * whole - 9 * dropped)
    ones = max(0, rest - dropped) // (60 * whole - dropped)
    count += dropped * (9 * tens + ones)
    second, frame = divmod(count, whole)
    width = len(parts[5])
    hms = f"{second // 3600:02}:{second // 60 % 60:02}:{second % 60:02}"
    return f"{hms}{parts[4]}{frame:0{width}}"
