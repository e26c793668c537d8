"""A setup with some keys changed."""

import math
import re
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


def moved(setup: Setup, key: str, by: float) -> Setup:
    """Return the setup with one value moved, unchecked: for what results change by when it is a little wrong.

    Parameters
    ----------
    setup
        Where the value comes from; a refractive index or a receiver's polarisation that is not given counts as what
        is taken for it. A transmitter with `position_m` moves along its direction.
    key
        As in `model.assumed`: receiver[2].tilt_deg, tracer.release_position_m[3].
    by
        In the value's unit.
    """
    place, name = key.split(".")
    table_name, index = _indexed(place)
    name, axis = _indexed(name)
    whole = getattr(setup, table_name)
    table = whole if index is None else whole[index]
    value = getattr(table, name)
    if name == "distance_m" and value is None:
        # what a tape measures wrongly is the distance, not the direction
        stretched = 1.0 + by / math.hypot(*table.position_m)
        name, value = "position_m", tuple(stretched * x for x in table.position_m)
    elif axis is not None:
        value = (*value[:axis], value[axis] + by, *value[axis + 1 :])
    else:
        if value is None:
            # of what is not given the value that is taken for it moves
            value = 1.0 if index is None else setup.received_fields()[index].angle_deg
        value += by
    table = table.model_copy(update={name: value})
    update = table if index is None else (*whole[:index], table, *whole[index + 1 :])
    return setup.model_copy(update={table_name: update})


def _indexed(part: str) -> tuple[str, int | None]:
    """Split receiver[2] into its name and 1."""
    found = re.fullmatch(r"(\w+)\[(\d+)\]", part)
    return (found[1], int(found[2]) - 1) if found else (part, None)
