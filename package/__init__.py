"""makeup-video: paint the makeup of a reference photo on every frame of a video.

The public names are those of `makeup_video.pipeline`. Each name is loaded when it is first used.
"""

TYPE_CHECKING = False  # type checkers take this for True; importing `typing` would take 2 ms
if TYPE_CHECKING:
    from makeup_video.pipeline import *

    __version__: str
else:  # hidden from type checkers, which would accept any name as an attribute of this module

    def __getattr__(name: str) -> object:
        # Both modules are imported late; otherwise every start of the command would wait for them.
        if name == "__version__":
            from importlib.metadata import version

            globals()[name] = version("makeup-video")
        elif name == "__all__" or not name.startswith("_"):
            from importlib import import_module

            public = import_module("makeup_video.pipeline")  # also sets the attribute `pipeline`
            if name in ("__all__", *public.__all__):
                globals()[name] = getattr(public, name)
        if name not in globals():
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return globals()[name]


def __dir__() -> list[str]:
    from importlib import import_module

    return sorted(["__version__", *import_module("makeup_video.pipeline").__all__])
