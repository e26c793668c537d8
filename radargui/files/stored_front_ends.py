"""Front ends as the results stored with runs know them: for the prior of other runs, and the prior a result had."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.run_header import is_run
from radargui.model.errors import FileError
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.setup import Setup
from radargui.model.setup_file import dump_setup

PRIOR = "front_end_prior"


@dataclass(frozen=True, slots=True)
class StoredFrontEnds:
    """What a run's result says about the front ends.

    Attributes
    ----------
    run
        Name of the run.
    setup_toml
        The setup it was made with.
    front_ends
        One a receiver.
    had_prior
        Whether they rest on other runs too.
    """

    run: str
    setup_toml: str = field(repr=False)
    front_ends: tuple[FrontEnd, ...]
    had_prior: bool


def read_front_ends(path: Path) -> StoredFrontEnds | None:
    """Return the front ends of a run's present result; None where it is no sound joint one with good receivers."""
    try:
        attributes = _attributes(path)
        channels = json.loads(hdf5.text(attributes, "channels"))
        made = hdf5.text(attributes, "status"), hdf5.text(attributes, "correction")
        if made != ("ok", "joint") or not channels or any(channel["verdict"] != "good" for channel in channels):
            return None
        front_ends, prior = tuple(_front_end(channel) for channel in channels), prior_in(attributes)
        return StoredFrontEnds(path.stem, hdf5.text(attributes, "setup"), front_ends, prior is not None and prior.used)
    except (FileError, ValueError, LookupError, TypeError):
        return None


def read_prior(path: Path, setup: Setup | None = None) -> FrontEndPrior | None:
    """Return the prior that a run's present result had, so that it can be computed again.

    None where it had none, or was not made with this setup, where one is given.
    """
    try:
        attributes = _attributes(path)
        is_other = setup is not None and hdf5.text(attributes, "setup") != dump_setup(setup)
        return None if is_other else prior_in(attributes)
    except (FileError, ValueError, LookupError, TypeError):
        return None


def _attributes(path: Path) -> Mapping[str, Any]:
    """Return the attributes of a run's present result; LookupError where it holds none, or a damaged one."""
    with hdf5.opened(path, "a run file", is_run) as file:
        attributes = file[layout.RESULTS].attrs
        if not hdf5.is_sound(attributes):
            raise LookupError(path)
        return dict(attributes)


def prior_in(attributes: Any) -> FrontEndPrior | None:
    """Return the prior that stands in the attributes of a group of results; None where there was none.

    Raises
    ------
    LookupError, TypeError, ValueError
        They are damaged.
    """
    document = json.loads(hdf5.text(attributes, PRIOR) or "null")
    if document is None:
        return None
    front_ends = tuple(_front_end(one) for one in document["front_ends"])
    return FrontEndPrior(tuple(map(str, document["runs"])), front_ends, bool(document["used"]))


def _front_end(values: Mapping[str, Any]) -> FrontEnd:
    keys = ("gain_ratio", "u_gain_ratio", "quadrature_error_deg", "u_quadrature_error_deg")
    gain, u_gain, angle, u_angle = (float(values[key]) for key in keys)
    if not (gain > 0.0 and u_gain > 0.0 and u_angle > 0.0):
        raise ValueError
    return FrontEnd(gain, u_gain, angle, u_angle)
