"""RadarGUI: record a particle-tracking radar, watch it live, measure the restitution of a falling sphere.

    import radargui

    run = radargui.open_run("run-0001.h5")
    result = radargui.process(run)
    for bounce in result.bounces:
        print(bounce.time_s, bounce.e, bounce.u_e_combined)

What `__all__` lists is public and stays; it is loaded when it is first used. Its types stand in `__init__.pyi`.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"
_PLACES = {
    "radargui.api": ("BounceTable", "Result", "Run", "open_run", "process", "series"),
    "radargui.model.errors": ("RadarGuiError",),
    "radargui.model.recording": ("Recording",),
    "radargui.model.channel_quality": ("ChannelQuality",),
    "radargui.model.result": ("Bounce", "FreeFall"),
    "radargui.model.setup": ("Setup", "read_setup"),
}
_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}
__all__ = ["__version__", *sorted(_PLACE_OF)]


def __getattr__(name: str) -> Any:
    if name not in _PLACE_OF:
        raise AttributeError(f"module 'radargui' has no attribute {name!r}")
    return getattr(import_module(_PLACE_OF[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
