"""Two results of a run side by side: what was set differently, and what came of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from radargui.experiment.reprocess import computed, own_setup, process_run
from radargui.files.access import Progress
from radargui.files.run_card import summarise
from radargui.files.stored_results import StoredResult, read_stored_results
from radargui.model.drop import figure_in
from radargui.model.result import RunResult
from radargui.model.setup import Setup, changed
from radargui.model.setup_error import differing

FIGURES = (
    ("e", "u_e", "u_e_combined", ""),
    ("drop_height_m", "", "", "m"),
    ("impact_speed_m_s", "", "", "m/s"),
    ("g_m_s2", "u_g_m_s2", "u_g_combined_m_s2", "m/s²"),
)


@dataclass(frozen=True, slots=True)
class Side:
    """One of the two results.

    Attributes
    ----------
    summary
        See `files.run_card.summarise`.
    setup
        What it was made with; None where this version cannot read it.
    """

    summary: Mapping[str, object]
    setup: Setup | None

    @classmethod
    def of(cls, result: RunResult) -> "Side":
        """Return a result that was made just now."""
        return cls(summarise(result), result.setup)


@dataclass(frozen=True, slots=True)
class ComparedFigure:
    """A figure of both results.

    Attributes
    ----------
    name, unit
        As in the summary.
    before, after
        None where it is not known.
    u_before, u_after
        Standard uncertainties, combined where that is known, else statistical; None where there are none.
    u_difference
        Larger statistical one of the two, which says how many digits the difference has. Samples and antennas are the
        same: what they leave open is common to both, and to add it would be wrong.
    """

    name: str
    unit: str
    before: float | None
    after: float | None
    u_before: float | None = None
    u_after: float | None = None
    u_difference: float | None = None

    @property
    def difference(self) -> float | None:
        """After less before; None where one is not known."""
        return None if self.before is None or self.after is None else self.after - self.before


@dataclass(frozen=True, slots=True)
class ChangedSetting:
    """A key of the setup with two values; None where it is left out."""

    key: str
    before: object
    after: object


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two results of one run.

    Attributes
    ----------
    run
        Run file.
    before, after
        The results.
    """

    run: Path
    before: Side
    after: Side

    @property
    def figures(self) -> tuple[ComparedFigure, ...]:
        """The figures of both."""
        return tuple(self._figure(*keys) for keys in FIGURES)

    def _figure(self, name: str, u: str, u_combined: str, unit: str) -> ComparedFigure:
        def both(key: str) -> tuple[float | None, float | None]:
            return figure_in(self.before.summary, key), figure_in(self.after.summary, key)

        own = both(u)
        before, after = (alone if whole is None else whole for alone, whole in zip(own, both(u_combined), strict=True))
        largest = max((one for one in own if one is not None), default=None)
        return ComparedFigure(name, unit, *both(name), before, after, largest)

    @property
    def settings(self) -> tuple[ChangedSetting, ...]:
        """What was set differently; empty where one of the setups cannot be read."""
        if self.before.setup is None or self.after.setup is None:
            return ()
        return changed_settings(self.before.setup, self.after.setup)


def compare_stored(run: Path) -> Comparison | None:
    """Return the result that is stored with a run beside the one before; None where there was none before.

    Raises
    ------
    FileError
        The run cannot be read.
    """
    stored = read_stored_results(run)
    return Comparison(run, _side(stored[-2]), _side(stored[-1])) if len(stored) > 1 else None


def compare_with(
    run: Path,
    progress: Progress | None = None,
    *,
    setup: Setup | None = None,
    changes: Mapping[str, Any] | None = None,
    keep: bool = False,
) -> Comparison:
    """Process a run with other settings and return the result beside the one that is stored; the samples stay.

    Parameters
    ----------
    run
        Run file.
    progress
        Called with the share done.
    setup
        Antennas, calibration, processing; None: what the run was recorded with.
    changes
        Keys of it with another value, such as `processing.correction`.
    keep
        Whether the new result takes the place of the stored one, whose figures are kept beside it.

    Raises
    ------
    FileError
        The run cannot be read, or the results not be kept.
    SetupError
        A value is not allowed.
    UsageError
        No setup is given and the run holds none.
    ProcessingError
        The samples do not fit the setup.
    """
    other = changed(setup or own_setup(run), changes or {}, "the other settings")
    stored = read_stored_results(run)
    before = _side(stored[-1]) if stored and stored[-1].is_present else Side.of(computed(run, own_setup(run)))
    after = process_run(run, other, progress=progress) if keep else computed(run, other, progress)
    return Comparison(run, before, Side.of(after))


def changed_settings(before: Setup, after: Setup) -> tuple[ChangedSetting, ...]:
    """Return the keys that two setups give different values, in the order of the setup file."""
    # of a calibration its file is named, not each covariance
    dump = partial(
        Setup.model_dump, by_alias=True, exclude_none=True, mode="json", exclude={"calibration": {"content"}}
    )
    return tuple(ChangedSetting(*one) for one in differing(dump(before), dump(after)))


def _side(stored: StoredResult) -> Side:
    return Side(stored.summary, stored.setup)
