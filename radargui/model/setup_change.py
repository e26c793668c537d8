"""A setup with some keys changed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from radargui.model.setup import Setup
from radargui.model.setup_file import plain, validate_setup


def changed(setup: Setup, changes: Mapping[str, Any], name: str = "setup") -> Setup:
    """Return the setup with some keys changed and all of it checked again.

    Parameters
    ----------
    setup
        Where the other keys come from.
    changes
        From "table.key" to the new value; None leaves the key as it is.
    name
        Whose wish it is, for messages.

    Raises
    ------
    SetupError
        A new value is not allowed.
    """
    wanted = {key: value for key, value in changes.items() if value is not None}
    if not wanted:
        return setup
    document = plain(setup)
    for place, value in wanted.items():
        table, _, key = place.partition(".")
        document.setdefault(table, {})[key] = value
    return validate_setup(document, name)
