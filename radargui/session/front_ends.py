"""Collect what earlier runs of a session say of the front ends: the prior of the next run."""

from itertools import islice
from pathlib import Path

from radargui.estimation.hardware import pool_constants
from radargui.files.stored_results import StoredFrontEnds, read_front_ends
from radargui.model.errors import RadarGuiError
from radargui.model.front_end import FrontEndPrior
from radargui.model.setup import Setup
from radargui.session.info import read_info
from radargui.session.session import run_paths

_HARDWARE = ("radar", "transmitter", "receiver", "daq")
_MOST_RUNS = 10
"""The latest; the mean of ten has a third of one run's uncertainty."""


def known_front_ends(run: Path, setup: Setup) -> FrontEndPrior | None:
    """Return what the runs before this one in its session say about the front ends; None where they say nothing.

    Counted are the last ten whose stored result is a joint one with good receivers, made under the same radar,
    antennas and device, and without a prior, so that no run counts twice; runs set aside are not. None too where
    `setup` asks for another correction, which would not use them.

    Parameters
    ----------
    run
        Run file in the folder of a session.
    setup
        Under which the run is processed.
    """
    # the joint estimate alone asks: nobody else shall wait until hundreds of earlier runs have been opened
    if setup.processing.correction != "joint":
        return None
    try:
        rejected = read_info(run.parent).rejected
    except RadarGuiError:
        return None
    paths = run_paths(run.parent)
    names = [path.name for path in paths]
    earlier = paths[: names.index(run.name)] if run.name in names else ()
    stored = (read_front_ends(path) for path in reversed(earlier) if path.name not in rejected)
    sound = (one for one in stored if one is not None and _same_hardware(one, setup))
    found = [*islice(sound, _MOST_RUNS)][::-1]
    if not found:
        return None
    return FrontEndPrior(tuple(stored.run for stored in found), pool_constants([stored.front_ends for stored in found]))


def _same_hardware(stored: StoredFrontEnds, setup: Setup) -> bool:
    same = all(getattr(stored.setup, part) == getattr(setup, part) for part in _HARDWARE)
    return same and len(stored.front_ends) == setup.n_receivers
