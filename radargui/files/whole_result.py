"""The present result of a run with all its values: what `process` gave, without computing it again."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import DTypeLike, NDArray

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.run_header import is_run
from radargui.files.run_results import are_made_of, bounces_in
from radargui.files.stored_front_ends import prior_in
from radargui.model.corrected import CorrectedIQ
from radargui.model.errors import FileError
from radargui.model.path import PathLengths
from radargui.model.quality import ChannelQuality
from radargui.model.recording import Excerpt, Recording
from radargui.model.result import RunResult, Status
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.model.track import Track
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget


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
    with hdf5.opened(path, "a run file", is_run) as file:
        if layout.RESULTS not in file:
            return None
        group = file[layout.RESULTS]
        if not hdf5.is_sound(group.attrs):
            raise FileError(f"{path}: its results are damaged.", remedy="Process the run again.")
        if not are_made_of(file, setup):
            return None
        return _Stored(group, path).result(setup, recording_of)


class _Stored:
    """A sound group of results; what it claims is checked against the samples. Bad values raise ValueError."""

    def __init__(self, group: Any, path: Path) -> None:
        self._group = group
        self._path = path

    def result(self, setup: Setup, recording_of: Callable[[Excerpt | None], Recording]) -> RunResult:
        excerpt = self._json("excerpt")
        recording = recording_of(None if excerpt is None else Excerpt(**excerpt))
        if self._text("status") not in get_args(Status):
            raise ValueError("status")
        paths = self._paths(recording, setup)
        return RunResult(
            recording,
            setup,
            status=self._text("status"),  # type: ignore[arg-type]  # one of them, as asked above
            reason=self._text("reason"),
            segment=self._segment(recording.n_samples),
            corrected=None if paths is None else self._corrected(paths, setup),
            paths=paths,
            track=self._track(recording),
            bounces=bounces_in(self._group, self._path),
            uncertainty_budget=self._budget(),
            warnings=tuple(self._json("warnings")),
            preliminary=bool(self._json("summary")["preliminary"]),
            front_end_prior=prior_in(self._group.attrs),
        )

    def _paths(self, recording: Recording, setup: Setup) -> PathLengths | None:
        if "paths" not in self._group:
            return None
        group, shape = self._group["paths"], (recording.n_receivers, recording.n_samples)
        change_m = self._values(group, "change_m", shape)
        return PathLengths(
            recording.time_s(),
            change_m / _per_rad(setup),
            change_m,
            self._values(group, "u_m", shape),
            self._values(group, "valid", shape, np.bool_),
            self._values(group, "piece", shape[1:], np.intp) if "piece" in group else None,
        )

    def _corrected(self, paths: PathLengths, setup: Setup) -> CorrectedIQ:
        group, shape = self._group["corrected"], paths.change_m.shape
        channels = tuple(
            ChannelQuality(**{**one, "prior_runs": tuple(one["prior_runs"])}) for one in self._json("channels")
        )
        if len(channels) != shape[0]:
            raise ValueError("channels")
        return CorrectedIQ(
            paths.time_s,
            self._values(group, "i", shape),
            self._values(group, "q", shape),
            paths.valid,
            paths.u_m / _per_rad(setup),
            self._text("correction"),
            channels,
        )

    def _track(self, recording: Recording) -> Track | None:
        if "track" not in self._group:
            return None
        group, count = self._group["track"], recording.n_samples
        return Track(
            recording.time_s(),
            self._values(group, "position_m", (3, count)),
            self._values(group, "u_position_m", (3, count)),
            self._values(group, "valid", (count,), np.bool_),
            self._text("geometry"),
            self._values(group, "u_combined_m", (3, count)) if "u_combined_m" in group else None,
        )

    def _budget(self) -> UncertaintyBudget | None:
        values = self._json("uncertainty_budget")
        if values is None:
            return None
        lines = {key: BudgetLine(**value) for key, value in values.items() if key != "assumed"}
        return UncertaintyBudget(**lines, assumed=values["assumed"])

    def _segment(self, count: int) -> Segment | None:
        if "segment" not in self._group.attrs:
            return None
        found = Segment(*(int(place) for place in self._group.attrs["segment"]))
        if not (0 <= found.first <= found.last <= count and 0 <= found.rest_first <= found.rest_last <= count):
            raise ValueError("segment")
        return found

    def _values(self, group: Any, name: str, shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> NDArray[Any]:
        found = hdf5.dataset(group, name, self._path, (len(shape),))
        if found.shape != shape:
            raise ValueError(name)
        return np.asarray(found[...], dtype)

    def _text(self, key: str) -> str:
        return hdf5.text(self._group.attrs, key)

    def _json(self, key: str) -> Any:
        return json.loads(self._text(key))


def _per_rad(setup: Setup) -> float:
    return setup.radar.wavelength_m / (2.0 * np.pi)
