"""Each error line says what to do, or docs/troubleshooting.md does."""

import ast
import re
from pathlib import Path

from makeup_video.pipeline import errors

ROOT = Path(__file__).parents[1]
FOLDERS = ("benchmark", "cli", "kernels", "pipeline", "web")
NAMES = {name for name, one in vars(errors).items() if isinstance(one, type)}
# words that tell the reader what to do, or which values are right
MEND = re.compile(
    r"""\b([Gg]ive|[Cc]hoose|[Uu]se|[Tt]ry|add|leave|install|run|make|wait|name|rename|free|put
    |quote|close|end|see|save|cut|convert|check|start|keep|reload|plug|set|deinterlace
    |must|needs?|needed|expected|is\ for|gets\ JPEG|known\ are)\b""",
    re.VERBOSE,
)
LEAST = 5  # letters; a shorter part of a message does not identify it


def text_of(node):
    """The literal text of a message, with "…" where a value goes."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(
            part.value if isinstance(part, ast.Constant) else "…" for part in node.values
        )
    return "…"


def messages():
    """(file, message) of every error that is made with a text of its own."""
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in NAMES and node.args:
                message = text_of(node.args[0])
                if pattern(message):
                    yield path.relative_to(ROOT).as_posix(), message


def pattern(message):
    """Matches a message, whatever its values are; None if too little literal text is left."""
    parts = [part.strip() for part in message.split("…") if part.strip()]
    if max(map(len, parts), default=0) < LEAST:
        return None
    return re.compile(".*".join(map(re.escape, parts)))


def rows():
    """The messages that docs/troubleshooting.md explains."""
    page = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
    cells = [line.split(" | ")[0] for line in page.splitlines() if line.startswith("|")]
    return [quoted for cell in cells for quoted in re.findall(r"`([^`]+)`", cell)]


def is_on(page, message):
    return any(
        (found := pattern(row)) and (found.search(message) or pattern(message).search(row))
        for row in page
    )


def test_every_error_line_says_what_to_do_or_the_page_does():
    page, made = rows(), list(messages())
    assert len(page) > 80 and len(made) > 250
    lost = [one for one in made if not MEND.search(one[1]) and not is_on(page, one[1])]
    assert not lost, "give these a row in docs/troubleshooting.md"


def test_a_line_without_a_mend_is_noticed():
    assert not MEND.search("… is odd: …") and not is_on(rows(), "… is odd: …")
