"""Read results back: the current one completely, all as figures, front ends and antennas as priors."""

import json
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import TypeAdapter

from radargui.files import hdf5, run_layout as layout
from radargui.files.run_card import Thumbnail, sound_results, summary_in, thumbnail_in
from radargui.files.run_results import (
    ARRAYS,
    DECISIONS,
    FINDING,
    FINDINGS,
    LIKELIHOOD,
    PRIOR,
    SETUP,
    SETUP_PRIOR,
    are_made_of,
    bounces_in,
    made_by,
)
from radargui.model.arrays import FloatArray
from radargui.model.channel_quality import ChannelQuality
from radargui.model.errors import FileError, SetupError
from radargui.model.finding import Finding, Severity, as_stored, finding_in
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.recording import Excerpt, Recording
from radargui.model.result import (
    Bounces,
    CorrectedIQ,
    FreeFall,
    Kinematics,
    PathLengths,
    RunResult,
    Segment,
    Status,
    Track,
)
from radargui.model.setup import Setup, dump_setup, parse_setup
from radargui.model.setup_pool import RunLikelihood, SetupPrior
from radargui.model.setup_posterior import SetupLikelihood, SetupValue, unknown_inputs
from radargui.model.uncertainty_budget import UncertaintyBudget

_EXCERPT = TypeAdapter[Excerpt | None](Excerpt | None)
_ROWS, _CHANNEL = TypeAdapter(list[dict[str, Any]]), TypeAdapter(ChannelQuality)
_BUDGET = TypeAdapter[UncertaintyBudget | None](UncertaintyBudget | None)
_SETUP = TypeAdapter(tuple[SetupValue, ...])
_SETUP_PRIOR = TypeAdapter[SetupPrior | None](SetupPrior | None)
_PRIOR = TypeAdapter[FrontEndPrior | None](FrontEndPrior | None)
_FRONT_END = TypeAdapter[FrontEnd](FrontEnd)
_LEFT_OUT = ("piece", "u_combined_m")
"""Arrays that not every result has."""


@dataclass(frozen=True, slots=True)
class StoredResult:
    """What a run gave under one setup and version.

    Attributes
    ----------
    summary
        See `files.run_card.summarise`.
    processed_at
        ISO 8601 date and time.
    version
        Of the program that made it.
    setup_toml
        The setup it was made with.
    is_present
        Whether it is the result that lists and reports show; else one before.
    thumbnail
        Height against time in a few points, or None.
    """

    summary: dict[str, object]
    processed_at: str
    version: str
    setup_toml: str = field(repr=False)
    is_present: bool
    thumbnail: Thumbnail | None = field(default=None, repr=False)

    @property
    def setup(self) -> Setup | None:
        """The setup it was made with; None where it is not valid for this version."""
        with suppress(SetupError):
            return parse_setup(self.setup_toml, "setup in the results")
        return None


def read_stored_results(path: Path) -> tuple[StoredResult, ...]:
    """Return all results stored with a run, the oldest first, the present one last.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        earlier = file.get(layout.EARLIER, {})
        groups = [(earlier[name], False) for name in sorted(earlier)]
        groups += [(file[layout.RESULTS], True)] if layout.RESULTS in file else []
        return tuple(_result(_sound(group, path), path, is_present) for group, is_present in groups)


def _sound(group: Any, path: Path) -> Any:
    """Return a group of results; FileError where it is damaged."""
    if not hdf5.is_sound(group.attrs):
        raise FileError(f"{path}: its results are damaged.", remedy="Process the run again.")
    return group


def _result(group: Any, path: Path, is_present: bool) -> StoredResult:
    at = hdf5.text(group.attrs, "processed_at")
    return StoredResult(summary_in(group), at, *made_by(group), is_present, thumbnail_in(group, path))


@dataclass(frozen=True, slots=True)
class StoredFindings:
    """What the present result of a run says in numbers: summary, impacts and first fall, budget; no samples.

    Attributes
    ----------
    summary
        See `files.run_card.summarise`.
    bounces, uncertainty_budget
        As in the result.
    fall
        Time [s], place [m] and fit of the first fall, shape (n,) and (3, n); None without one. Only this part of the
        track is read.
    """

    summary: dict[str, object]
    bounces: Bounces
    uncertainty_budget: UncertaintyBudget | None
    fall: tuple[FloatArray, FloatArray, FreeFall] | None


def read_findings(path: Path) -> StoredFindings | None:
    """Return what a run's present result says in numbers, in milliseconds; None where it holds none.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        if (results := sound_results(file)) is None:
            return None
        budget = _BUDGET.validate_json(hdf5.text(results.attrs, "uncertainty_budget"))
        bounces, fall = bounces_in(results, path), None
        if "track" in results and (fit := bounces.free_fall) is not None:
            time_s = np.asarray(hdf5.dataset(results["track"], "time_s", path, (1,))[...], np.float64)
            places = hdf5.dataset(results["track"], "position_m", path, (2,))
            first, last = np.searchsorted(time_s, [fit.first_time_s, fit.last_time_s])
            fall = time_s[first : last + 1], np.asarray(places[:, first : last + 1], np.float64), fit
        return StoredFindings(summary_in(results), bounces, budget, fall)


@dataclass(frozen=True, slots=True)
class StoredFrontEnds:
    """What a run's result says about the front ends.

    Attributes
    ----------
    run
        Name of the run.
    setup
        What it was made with.
    front_ends
        One a receiver.
    """

    run: str
    setup: Setup = field(repr=False)
    front_ends: tuple[FrontEnd, ...]


def read_front_ends(path: Path) -> StoredFrontEnds | None:
    """Return the front ends of a run's present result.

    None where it is no sound joint one with good receivers, or rests on other runs too.
    """
    with suppress(FileError, SetupError, ValueError, LookupError, TypeError):
        attributes = _attributes(path)
        channels = _channels_in(attributes)
        made = hdf5.text(attributes, "status"), hdf5.text(attributes, "correction")
        if made != ("ok", "joint") or not channels or any(channel.verdict != "good" for channel in channels):
            return None
        if (prior := _prior_in(attributes)) is not None and prior.used:
            return None
        setup = parse_setup(hdf5.text(attributes, "setup"), "setup in the results")
        keys = [one.name for one in fields(FrontEnd)]
        numbers = [{key: getattr(one, key) for key in keys} for one in channels]
        # of None there is no number
        front_ends = tuple(_FRONT_END.validate_python(row) for row in numbers)
        _want_possible(front_ends)
        return StoredFrontEnds(path.stem, setup, front_ends)
    return None


def read_setup_likelihood(path: Path) -> RunLikelihood | None:
    """Return what the present result of a run says of the setup; None where it says nothing, as those of old."""
    with suppress(FileError, SetupError, ValueError, LookupError, TypeError, np.linalg.LinAlgError):
        attributes = _attributes(path)
        setup = parse_setup(hdf5.text(attributes, "setup"), "setup in the results")
        if hdf5.text(attributes, "status") != "ok" or (found := _likelihood_in(attributes, setup)) is None:
            return None
        prior = _setup_prior_in(attributes)
        return RunLikelihood(path.stem, setup, found, prior is not None and not prior.used)
    return None


def _likelihood_in(attributes: Any, setup: Setup) -> SetupLikelihood | None:
    stored = json.loads(hdf5.text(attributes, LIKELIHOOD) or "null")
    if stored is None:
        return None
    n = len(unknown_inputs(setup)[0])
    matrix, vector = (np.array(stored[name], dtype=np.float64) for name in ("matrix", "vector"))
    # a damaged number would bend every run of the session
    if matrix.shape != (n, n) or vector.shape != (n,) or not (np.isfinite(matrix).all() and np.isfinite(vector).all()):
        raise ValueError
    return SetupLikelihood.sound(matrix, vector)


def _setup_prior_in(attributes: Any) -> SetupPrior | None:
    return _SETUP_PRIOR.validate_json(hdf5.text(attributes, SETUP_PRIOR) or "null")


def read_prior(path: Path, setup: Setup | None = None) -> FrontEndPrior | None:
    """Return the prior that a run's present result had, so that it can be computed again.

    None where it had none, or was not made with this setup, where one is given.
    """
    with suppress(FileError, ValueError, LookupError, TypeError):
        attributes = _attributes(path)
        is_other = setup is not None and hdf5.text(attributes, "setup") != dump_setup(setup)
        return None if is_other else _prior_in(attributes)
    return None


def read_setup_prior(path: Path, setup: Setup) -> SetupPrior | None:
    """Return what other runs said of the setup when a run's present result was made with it; None as `read_prior`."""
    with suppress(FileError, ValueError, LookupError, TypeError):
        attributes = _attributes(path)
        return _setup_prior_in(attributes) if hdf5.text(attributes, "setup") == dump_setup(setup) else None
    return None


def _attributes(path: Path) -> Mapping[str, Any]:
    """Return the attributes of a run's present result; LookupError where it holds none, or a damaged one."""
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        if (results := sound_results(file)) is None:
            raise LookupError(path)
        return dict(results.attrs)


def _channels_in(attributes: Any) -> tuple[ChannelQuality, ...]:
    """Return the quality of the receivers among the attributes of results."""
    rows = _ROWS.validate_json(hdf5.text(attributes, "channels"))
    return tuple(replace(_CHANNEL.validate_python({**row, FINDING: None}), finding=_finding_of(row)) for row in rows)


def _finding_of(row: Mapping[str, Any]) -> Finding | None:
    if FINDING in row:
        return None if row[FINDING] is None else finding_in(row[FINDING])
    # an older version kept the sentence alone
    severity: Severity = "refuse" if row["verdict"] == "rejected" else "warn"
    return None if row["verdict"] == "good" else as_stored(str(row["reason"]), severity)


def _prior_in(attributes: Any) -> FrontEndPrior | None:
    """Return the prior among the attributes of results; None where there was none, or 0.1 wrote them."""
    prior = _PRIOR.validate_json(hdf5.text(attributes, PRIOR) or "null")
    _want_possible(prior.front_ends if prior else ())
    return prior


def _want_possible(front_ends: Iterable[FrontEnd]) -> None:
    # a prior divides by these: a damaged zero would weigh more than all runs together
    if any(
        not value > 0.0
        for one in front_ends
        for value in (one.gain_ratio, one.u_gain_ratio, one.u_quadrature_error_deg, *one.u_harmonics)
    ):
        raise ValueError


def read_whole_result(
    path: Path, setup: Setup, recording_of: Callable[[Excerpt | None], Recording]
) -> RunResult | None:
    """Return the result stored with a run; None where there is none that this version made of these samples with setup.

    Numbers are those that were computed; I and Q, for display, have single precision. What a correction found on its
    way (`CorrectedIQ.steps`) is not stored.

    Parameters
    ----------
    path
        Run file.
    setup
        What the result shall have been made with.
    recording_of
        Reads the samples of the run, all of them or those of an excerpt.

    Raises
    ------
    FileError
        Unreadable, no run file, or the results are damaged; what `recording_of` raises.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        if layout.RESULTS not in file:
            return None
        group = _sound(file[layout.RESULTS], path)
        return _Stored(group, path).result(setup, recording_of) if are_made_of(file, setup) else None


class _Stored:
    """A sound group of results; what it claims is checked against the samples. Bad values raise ValueError."""

    def __init__(self, group: Any, path: Path) -> None:
        self._group = group
        self._path = path

    def result(self, setup: Setup, recording_of: Callable[[Excerpt | None], Recording]) -> RunResult:
        recording = recording_of(_EXCERPT.validate_json(self._text("excerpt")))
        if self._text("status") not in get_args(Status):
            raise ValueError("status")
        paths = self._paths(recording, setup)
        return RunResult(
            recording,
            setup,
            status=self._text("status"),  # type: ignore[arg-type]  # one of them, as asked above
            segment=self._segment(recording.n_samples),
            corrected=None if paths is None else self._corrected(paths, setup),
            paths=paths,
            track=self._track(recording),
            bounces=bounces_in(self._group, self._path),
            motion=self._motion(),
            uncertainty_budget=_BUDGET.validate_json(self._text("uncertainty_budget")),
            # what earlier versions wrote knows of none
            setup_posterior=_SETUP.validate_json(hdf5.text(self._group.attrs, SETUP) or "[]"),
            setup_likelihood=_likelihood_in(self._group.attrs, setup),
            setup_prior=_setup_prior_in(self._group.attrs),
            findings=self._findings(),
            preliminary=bool(summary_in(self._group)["preliminary"]),
            front_end_prior=_prior_in(self._group.attrs),
        )

    def _paths(self, recording: Recording, setup: Setup) -> PathLengths | None:
        if "paths" not in self._group:
            return None
        found = self._arrays("paths", recording.n_receivers, recording.n_samples)
        return PathLengths(recording.time_s(), phase_rad=found["change_m"] / _per_rad(setup), **found)

    def _corrected(self, paths: PathLengths, setup: Setup) -> CorrectedIQ:
        channels = _channels_in(self._group.attrs)
        if len(channels) != len(paths.change_m):
            raise ValueError("channels")
        return CorrectedIQ(
            paths.time_s,
            **self._arrays("corrected", *paths.change_m.shape),
            valid=paths.valid,
            u_phase_rad=paths.u_m / _per_rad(setup),
            method=self._text("correction"),
            channels=channels,
            # results of 0.1 have none
            decisions=tuple(json.loads(self._group.attrs.get(DECISIONS, "[]"))),
        )

    def _track(self, recording: Recording) -> Track | None:
        if "track" not in self._group:
            return None
        found = self._arrays("track", 3, recording.n_samples)
        return Track(recording.time_s(), geometry=self._text("geometry"), **found)

    def _motion(self) -> Kinematics | None:
        # results of earlier versions have none
        if "motion" not in self._group:
            return None
        group = self._group["motion"]
        time_s = np.asarray(hdf5.dataset(group, "time_s", self._path, (1,))[...], np.float64)
        found: dict[str, Any] = {}
        for name in ARRAYS["motion"].keys() - {"time_s"}:
            shape = time_s.shape if name == "flight" else (3, time_s.size)
            stored = hdf5.dataset(group, name, self._path, (len(shape),))
            if stored.shape != shape:
                raise ValueError(name)
            found[name] = np.asarray(stored[...], np.intp if name == "flight" else np.float64)
        return Kinematics(time_s, **found)

    def _segment(self, count: int) -> Segment | None:
        if "segment" not in self._group.attrs:
            return None
        found = Segment(*(int(place) for place in self._group.attrs["segment"]))
        if not (0 <= found.first <= found.last <= count and 0 <= found.rest_first <= found.rest_last <= count):
            raise ValueError("segment")
        return found

    def _arrays(self, part: str, n_rows: int, n_samples: int) -> dict[str, Any]:
        group = self._group[part]
        found: dict[str, Any] = {}
        # times and phases follow from the samples and the lengths
        for name in ARRAYS[part].keys() - {"time_s", "phase_rad"}:
            if name in _LEFT_OUT and name not in group:
                continue
            is_row = name == "piece" or (part, name) == ("track", "valid")
            shape = (n_samples,) if is_row else (n_rows, n_samples)
            stored = hdf5.dataset(group, name, self._path, (len(shape),))
            if stored.shape != shape:
                raise ValueError(name)
            found[name] = np.asarray(stored[...], {"valid": np.bool_, "piece": np.intp}.get(name, np.float64))
        return found

    def _findings(self) -> tuple[Finding, ...]:
        if FINDINGS in self._group.attrs:
            return tuple(map(finding_in, json.loads(self._text(FINDINGS))))
        # an older version kept sentences alone
        reason, warnings = self._text("reason"), json.loads(self._text("warnings"))
        refused = (as_stored(reason, "refuse"),) if reason else ()
        return (*refused, *map(as_stored, warnings))

    def _text(self, key: str) -> str:
        return hdf5.text(self._group.attrs, key)


def _per_rad(setup: Setup) -> float:
    return setup.radar.wavelength_m / (2.0 * np.pi)
