"""The registry of kinds of makeup. One file here holds all that is known of a kind.

Look files, command line, page, finishes, messages, renderer, warm-up, benchmark, documents and the
tests over all kinds use this registry.
"""

from importlib import import_module

from makeup_video.pipeline.look.kinds.kind import Kind

# In the order in which people name them.
_NAMES = ("lipstick", "eyeshadow", "eyeliner", "blush", "highlighter")

KINDS: dict[str, Kind] = {name: import_module(f"{__name__}.{name}").KIND for name in _NAMES}
# The kinds by the part of a look that they belong to.
PARTS: dict[str, Kind] = {kind.part: kind for kind in KINDS.values()}
# The kinds' names in the order in which they are painted, whatever the order in a look file.
PAINTED: tuple[str, ...] = tuple(sorted(KINDS, key=lambda name: KINDS[name].order))
