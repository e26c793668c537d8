"""Collect what other runs of a session say of antennas, release and wavelength: the prior of a run.

Collect what earlier runs of a session say of the front ends: the prior of the next run.
"""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from radargui import __version__
from radargui.estimation.hardware import pool_constants
from radargui.files.access import sha256_of
from radargui.files.stored_results import StoredFrontEnds, read_front_ends, read_setup_likelihood
from radargui.model.calibration import Calibration, Origin
from radargui.model.errors import RadarGuiError
from radargui.model.front_end import FrontEndPrior
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior, known_setup, pooled_calibration
from radargui.session.info import read_info
from radargui.session.session import run_paths

_HARDWARE = ("radar", "transmitter", "receiver", "daq")
_MAX_RUNS = 10
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
    if (others := _others(run)) is None:
        return None
    stored = map(read_front_ends, reversed(others[0]))
    sound = (one for one in stored if one is not None and _same_hardware(one, setup))
    found = [*islice(sound, _MAX_RUNS)][::-1]
    if not found:
        return None
    return FrontEndPrior(tuple(stored.run for stored in found), pool_constants([stored.front_ends for stored in found]))


def _others(run: Path) -> tuple[list[Path], list[Path]] | None:
    """Return the runs before and after one in its session but for those set aside; None where it is in no session."""
    try:
        rejected = read_info(run.parent).rejected
    except RadarGuiError:
        return None
    paths = run_paths(run.parent)
    names = [path.name for path in paths]
    if run.name not in names:
        return None
    place = names.index(run.name)
    earlier, later = (
        [path for path in side if path.name not in rejected] for side in (paths[:place], paths[place + 1 :])
    )
    return earlier, later


def _same_hardware(stored: StoredFrontEnds, setup: Setup) -> bool:
    same = all(getattr(stored.setup, part) == getattr(setup, part) for part in _HARDWARE)
    return same and len(stored.front_ends) == setup.n_receivers


def known_setup_of_run(run: Path, setup: Setup, *, only_again: bool = False) -> SetupPrior | None:
    """Return what the other runs of its session say about the antennas of a run; None where they say nothing.

    Runs that were set aside say nothing, nor those made before this was stored. A run that contradicted those before
    it is held against them alone, again. None too where `setup` does not pool.

    Parameters
    ----------
    run
        Run file in the folder of a session.
    setup
        Under which the run is processed.
    only_again
        Whether the run's own stored result must be of the same antennas: of runs that are computed together each finds
        the others as they were then, whichever is first.
    """
    # the joint estimate alone asks: nobody else shall wait until hundreds of other runs have been opened
    if setup.processing.correction != "joint" or not setup.processing.pool_setup:
        return None
    if (others := _others(run)) is None:
        return None
    (earlier, later), own = others, read_setup_likelihood(run)
    if only_again and not (own and own.is_of(setup)):
        return None
    sides = earlier, later if own is None or not own.begins else ()
    before, after = ([one for path in side if (one := read_setup_likelihood(path))] for side in sides)
    return known_setup(before, after, setup)


def calibration_of_runs(runs: Sequence[Path], setup: Setup, made_at: str, operator: str) -> Calibration | None:
    """Return the antennas of a setup as the stored results of runs say them together; None where they say nothing.

    Parameters
    ----------
    runs
        Run files in the order of their recording.
    setup
        What states the antennas.
    made_at, operator
        Date and time, ISO 8601, and who takes it over.

    Raises
    ------
    FileError
        A run that counts cannot be read.
    """
    said = {path: one for path in runs if (one := read_setup_likelihood(path)) and one.is_of(setup)}
    files = {path.name: sha256_of(path) for path in said}
    origin = Origin(made_at, operator, __version__, files, ("fall",) * len(files))
    return pooled_calibration(list(said.values()), setup, origin)
