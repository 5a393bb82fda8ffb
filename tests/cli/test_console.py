"""Log lines: a terminal shows every character of a name and obeys none."""

import pytest
from makeup_video.cli.console import log, printable
from makeup_video.web.upload import without_controls


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Rouge N\u00b0 5, 日本, \U0001f484", "Rouge N\u00b0 5, 日本, \U0001f484"),
        ("a\nb\tc\rd", r"a\nb\tc\rd"),
        ("\x1b[31m \x9b \x07", r"\x1b[31m \x9b \x07"),
        ("\u202eright to left\u2066", r"\u202eright to left\u2066"),
        ("a\u200bb\u200e\u200f", r"a\u200bb\u200e\u200f"),
        ("a\u061cb\u2060c\ufeff", r"a\u061cb\u2060c\ufeff"),
        ("\u0645\u06cc\u200c\u062e, \U0001f469\u200d\U0001f9b0",) * 2,
        ("bad\udcff.jpg", r"bad\udcff.jpg"),
    ],
)
def test_terminal_control_characters_are_escaped(capsys, text, shown):
    assert printable(text) == shown
    log(text)
    assert capsys.readouterr().err == shown + "\n"


def test_the_page_removes_what_a_terminal_escapes():
    for sign in map(chr, range(0x10000)):
        assert (without_controls(sign) == "") == (printable(sign) != sign), hex(ord(sign))
