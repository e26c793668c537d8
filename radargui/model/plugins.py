"""Find what a laboratory's own packages add by entry points: sources, corrections, figures, laws."""

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Literal

from radargui.model.errors import RadarGuiError

Kind = Literal["sources", "corrections", "figures", "laws"]


@cache
def plugins(kind: Kind) -> dict[str, EntryPoint]:
    """Return the installed plug-ins of a kind by name: the entry points of the group `radargui.KIND`."""
    return {point.name: point for point in entry_points(group=f"radargui.{kind}")}


def load_plugin(kind: Kind, name: str) -> Any:
    """Return the object that an entry point names; docs/plugins.md says what it must be.

    Raises
    ------
    RadarGuiError
        None of this name is installed, or it cannot be loaded.
    """
    point = plugins(kind).get(name)
    if point is None:
        raise RadarGuiError(f"No plug-in {name!r} among the {kind} is installed", remedy="Install its package.")
    try:
        return point.load()
    except Exception as error:
        raise RadarGuiError(
            f"The plug-in {name} ({point.value}) cannot be loaded: {type(error).__name__}: {error}"
        ) from error
