"""Choose the setup of a command: a file, changed by options."""

import math
from pathlib import Path

from radargui.model.errors import UsageError
from radargui.model.setup import Setup, changed, read_setup
from radargui.system.resources import default_setup_path

COMMAND_LINE = "command line"
"""Whose wish an option is, for messages."""


def named_or_default(path: Path | None) -> Setup:
    """Return the setup of a file, the shipped default where none is named.

    Raises
    ------
    SetupError
        The file cannot be used.
    """
    return read_setup(path or default_setup_path())


def processing_changes(correction: str | None, geometry: str | None, drop: int | None = None) -> dict[str, str | int]:
    """Return what options say instead of any setup, for `changed`; refused before any work where no setup allows it.

    Raises
    ------
    SetupError
        A value is not allowed.
    """
    options = {"processing.correction": correction, "processing.geometry": geometry, "processing.drop": drop}
    wanted = {key: value for key, value in options.items() if value is not None}
    changed(named_or_default(None), wanted, COMMAND_LINE)
    return wanted


def parse_release(text: str | None) -> list[float] | None:
    """Return the place that `--release X,Y,Z` names, in metres.

    Raises
    ------
    UsageError
        Not three numbers.
    """
    if text is None:
        return None
    try:
        place = [float(part) for part in text.split(",")]
    except ValueError:
        place = []
    if len(place) != 3:
        raise UsageError(f"--release = {text!r}, allowed: X,Y,Z, three numbers in m")
    return place


def positive(name: str, value: float | None) -> None:
    """Make sure that an option's value is a number above zero or not given.

    Raises
    ------
    UsageError
        It is not.
    """
    if value is not None and not (math.isfinite(value) and value > 0.0):
        raise UsageError(f"{name} = {value:g}, allowed: a number above 0")
