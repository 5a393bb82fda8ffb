"""Says why faces that were found were not painted, or not with the whole look."""

from collections.abc import Collection

from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.offline.report import Report

_MOST_NUMBERS = 10  # of faces in a message
_WHOM = {"all": "the faces found", "largest": "the largest face"}


def tell_unpainted(
    report: Report,
    look: Look,
    faces: str,
    chosen_frames: int,
    numbers: set[int],
    painted_areas: Collection[str],
) -> None:
    """Write the reason into a report that already has its other counts.

    chosen_frames, numbers, painted_areas: as in Composite.
    """
    if not report.frames_with_face:
        return
    kinds = {layer.kind for layer in look.painted}
    meant = dict.fromkeys(k.must_see for k in KINDS.values() if k.name in kinds)
    unseen = [part for part in meant if part not in painted_areas]
    if not chosen_frames and faces.isdigit():
        report.why_unpainted = f"face {faces} was chosen, but {_numbered(sorted(numbers))}"
    elif not meant:
        report.why_unpainted = "the look has no opacity, no gloss and no reflection"
    elif unseen:
        whom = _WHOM.get(faces, f"face {faces}")
        report.why_unpainted = f"no {' or '.join(unseen)} could be seen in {whom}"
        if not painted_areas:
            report.why_unpainted += f"; {report.turn_first}"


def _numbered(numbers: list[int]) -> str:
    """The faces that were seen, in words, at most ten of them by number."""
    texts = [str(number) for number in numbers]
    if len(texts) > _MOST_NUMBERS:
        texts[_MOST_NUMBERS:] = [f"{len(texts) - _MOST_NUMBERS} more"]
    if len(texts) < 2:
        return f"the only face seen was {''.join(texts)}" if texts else "no face was seen for long"
    return f"the faces seen were {', '.join(texts[:-1])} and {texts[-1]}"
