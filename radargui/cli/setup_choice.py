"""The setup that a command works with: a file, and what options say instead of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from radargui.model.errors import UsageError
from radargui.model.resources import default_setup_path
from radargui.model.setup import Setup
from radargui.model.setup_change import changed
from radargui.model.setup_file import read_setup

RUN_SUFFIXES = (".h5", ".hdf5")


def named_or_default(path: Path | None) -> Setup:
    """Return the setup of a file, the shipped default where none is named.

    Raises
    ------
    SetupError
        The file cannot be used.
    """
    return read_setup(path or default_setup_path())


def own_setup(file: Path) -> Setup | None:
    """Return the setup that a recording brings with it; None where it has none.

    Raises
    ------
    FileError
        A run file that cannot be read.
    SetupError
        The setup in it is not valid for this version.
    """
    if file.suffix.lower() not in RUN_SUFFIXES:
        return None
    # h5py is not needed for the other kinds
    from radargui.files.run_file import read_run_setup

    return read_run_setup(file)


def override(setup: Setup, changes: dict[str, Any]) -> Setup:
    """Return the setup with some keys changed and all of it checked again.

    Parameters
    ----------
    setup
        Where the other keys come from.
    changes
        From "table.key" to the new value; None leaves the key as it is.

    Raises
    ------
    SetupError
        A new value is not allowed.
    """
    return changed(setup, changes, "command line")


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


def positive(name: str, value: float | None) -> float | None:
    """Return an option's value where it is a number above zero or not given.

    Raises
    ------
    UsageError
        It is not.
    """
    if value is not None and not (math.isfinite(value) and value > 0.0):
        raise UsageError(f"{name} = {value:g}, allowed: a number above 0")
    return value
