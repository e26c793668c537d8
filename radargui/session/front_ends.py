"""What the earlier runs of a session know about the front ends: the prior of the next."""

from pathlib import Path

from radargui.estimation.hardware import pool_constants
from radargui.files.stored_results import StoredFrontEnds, read_front_ends
from radargui.model.errors import RadarGuiError
from radargui.model.front_end import FrontEndPrior
from radargui.model.setup import Setup
from radargui.model.setup_file import parse_setup
from radargui.session.info import read_info
from radargui.session.session import run_paths

_MOST_RUNS = 10
"""The latest; the mean of ten has a third of one run's uncertainty."""


def known_front_ends(run: Path, setup: Setup) -> FrontEndPrior | None:
    """Return what the runs before this one in its session say about the front ends; None where they say nothing.

    Counted are the last ten whose stored result is a joint one with good receivers, made under the same radar,
    antennas and device, and without a prior, so that no run counts twice; runs set aside are not.

    Parameters
    ----------
    run
        Run file in the folder of a session.
    setup
        Under which the run is processed.
    """
    try:
        rejected = read_info(run.parent).rejected
    except RadarGuiError:
        return None
    earlier: list[Path] = []
    for path in run_paths(run.parent):
        if path.name == run.name:
            break
        earlier.append(path)
    else:
        return None
    found: list[StoredFrontEnds] = []
    for path in reversed(earlier):
        stored = None if path.name in rejected else read_front_ends(path)
        if stored is not None and not stored.had_prior and _same_hardware(stored, setup):
            found.insert(0, stored)
        if len(found) == _MOST_RUNS:
            break
    if not found:
        return None
    return FrontEndPrior(tuple(stored.run for stored in found), pool_constants([stored.front_ends for stored in found]))


def _same_hardware(stored: StoredFrontEnds, setup: Setup) -> bool:
    try:
        other = parse_setup(stored.setup_toml, "setup in the results")
    except RadarGuiError:
        return False
    return (
        other.radar == setup.radar
        and other.transmitter == setup.transmitter
        and other.receiver == setup.receiver
        and other.daq == setup.daq
        and len(stored.front_ends) == setup.n_receivers
    )
