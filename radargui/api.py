"""The door for programmers: open a recording, process it, take the results as arrays or tables."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex, overload

import numpy as np

from radargui.files.access import want_file
from radargui.files.formats import RUN, format_of, own_setup_of
from radargui.files.reading import parse_channel_map, read_recording
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.channel_quality import ChannelQuality
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.recording import Recording
from radargui.model.result import Bounce, FreeFall, Kinematics, RunResult, Status
from radargui.model.setup import Setup, changed, read_setup
from radargui.model.setup_pool import RunLikelihood, known_setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process as process_recording
from radargui.report.tables import BOUNCE_HEADER, columns_of, track_header
from radargui.restitution.findings import Findings
from radargui.restitution.speed_models import speed_model
from radargui.session.session import Session

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, slots=True)
class Run:
    """A recording with the setup it is processed with.

    Attributes
    ----------
    recording
        Raw samples; `recording.volts()` and `recording.time_s()` are arrays.
    setup
        Antennas, tracer, processing.
    """

    recording: Recording
    setup: Setup


class BounceTable(tuple[Bounce, ...]):
    """The impacts of a run in time order: a tuple of `Bounce`, and its columns as arrays."""

    __slots__ = ()

    @overload
    def __getitem__(self, key: SupportsIndex) -> Bounce: ...
    @overload
    def __getitem__(self, key: slice) -> tuple[Bounce, ...]: ...
    @overload
    def __getitem__(self, key: str) -> np.ndarray[Any, Any]: ...
    def __getitem__(self, key: Any) -> Any:
        """Return an impact by its place, or a column of bounces.csv by its name, shape (n_impacts,)."""
        return np.array([getattr(one, key) for one in self]) if isinstance(key, str) else super().__getitem__(key)

    def to_pandas(self) -> pandas.DataFrame:
        """Return one row an impact with the columns of bounces.csv; needs pandas."""
        return _view("pandas").DataFrame([asdict(one) for one in self], columns=list(BOUNCE_HEADER))


@dataclass(frozen=True, slots=True)
class Result:
    """What a run gave. Arrays have one column a stored sample; NaN where unknown, lengths in m, times in s.

    Attributes
    ----------
    details
        All that the program itself knows of the result; not promised to stay as it is.
    """

    details: RunResult = field(repr=False)

    @property
    def status(self) -> Status:
        """One of ok, no_motion (an answer) and rejected."""
        return self.details.status

    @property
    def reason(self) -> str:
        """Why the status is not ok."""
        return self.details.reason

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences for people."""
        return self.details.warnings

    @property
    def correction(self) -> str | None:
        """The correction used, another than asked for where that did not fit; None without motion."""
        quality = self.details.quality
        return quality.method if quality else None

    @property
    def channels(self) -> tuple[ChannelQuality, ...]:
        """Quality of each receiver; empty without motion."""
        quality = self.details.quality
        return quality.channels if quality else ()

    @property
    def bounces(self) -> BounceTable:
        """The impacts; each e with `u_e` (statistical) and `u_e_combined` (antennas, floor and sphere too)."""
        return BounceTable(self.details.bounces.impacts)

    @property
    def motion(self) -> Kinematics | None:
        """Place, velocity and acceleration a thousand times a second, each with its u; None where they are unknown.

        Of `joint` and `flights`; the columns of motion.csv.
        """
        return self.details.motion

    @property
    def free_fall(self) -> FreeFall | None:
        """The first fall against the parabola, with g and its statistical u; None where none can be fitted."""
        return self.details.bounces.free_fall

    @property
    def u_g_combined_m_s2(self) -> float | None:
        """Uncertainty of the fall's g with what antennas, release, clock and sphere leave open; None where unknown."""
        budget = self.details.uncertainty_budget
        return budget.g_m_s2.combined if self.free_fall and budget else None

    @property
    def time_s(self) -> FloatArray:
        """Time of each sample, shape (n_samples,)."""
        return self.details.recording.time_s()

    @property
    def path_m(self) -> FloatArray:
        """Change of each path transmitter, sphere, receiver since the rest, shape (n_receivers, n_samples)."""
        return self._rows("L{}_m")

    @property
    def u_path_m(self) -> FloatArray:
        """Standard uncertainty of `path_m`, same shape."""
        return self._rows("u_L{}_m")

    @property
    def position_m(self) -> FloatArray:
        """Centre of the sphere, shape (3, n_samples); NaN with fewer than three receivers."""
        return self._of("x_m", "y_m", "z_m")

    @property
    def u_position_m(self) -> FloatArray:
        """Standard uncertainty of `position_m` from noise, fit and misfit, same shape."""
        return self._of("ux_m", "uy_m", "uz_m")

    @property
    def u_position_combined_m(self) -> FloatArray:
        """The same with what antennas, release and sphere leave open; NaN where it was not carried."""
        return self._of("ux_combined_m", "uy_combined_m", "uz_combined_m")

    @property
    def valid(self) -> BoolArray:
        """Which samples the signal supports, shape (n_samples,); none of a rejected run."""
        return np.asarray(columns_of(self.details)["valid"].values, dtype=np.bool_)

    def to_pandas(self) -> pandas.DataFrame:
        """Return one row a sample with the columns of track.csv; needs pandas."""
        columns = columns_of(self.details)
        return _view("pandas").DataFrame(
            {name: columns[name].values for name in track_header(self.details.recording.n_receivers)}
        )

    def to_xarray(self) -> xarray.Dataset:
        """Return path lengths and position over the coordinates time_s, receiver and axis; needs xarray."""
        lengths, place = ("receiver", "time_s"), ("axis", "time_s")
        data: dict[str, tuple[Any, Any]] = {
            **{name: (lengths, getattr(self, name)) for name in ("path_m", "u_path_m")},
            **{name: (place, getattr(self, name)) for name in ("position_m", "u_position_m", "u_position_combined_m")},
            "valid": (("time_s",), self.valid),
        }
        receivers = np.arange(1, self.details.recording.n_receivers + 1)
        coordinates = {"time_s": self.time_s, "receiver": receivers, "axis": list("xyz")}
        attributes = {"status": self.status, "correction": self.correction or ""}
        return _view("xarray").Dataset(data, coordinates, attributes)

    def _rows(self, name: str) -> FloatArray:
        return self._of(*(name.format(number + 1) for number in range(self.details.recording.n_receivers)))

    def _of(self, *names: str) -> FloatArray:
        columns = columns_of(self.details)
        return np.stack([np.asarray(columns[name].values, dtype=np.float64) for name in names])


def open_run(
    path: str | Path,
    *,
    setup: Setup | str | Path | None = None,
    channels: str | None = None,
    rate_hz: float | None = None,
) -> Run:
    """Open a recording: a run of RadarGUI, CSV, MATLAB, TDMS or SigMF.

    Parameters
    ----------
    path
        The file.
    setup
        Setup, or the file that holds it; None: the run's own, or the one that an export of it carries.
    channels
        Which columns or variables are I1, Q1, ..., as `--channels` of the command line: "I1=x,Q1=y".
    rate_hz
        Samples per second where the file has no rate.

    Raises
    ------
    RadarGuiError
        The file cannot be read, or there is no setup that is valid.
    """
    path = Path(path)
    want_file(path)
    if not isinstance(setup, Setup):
        setup = read_setup(setup) if setup is not None else own_setup_of(path)
    if setup is None:
        raise UsageError(f"{path} brings no setup", remedy="Give open_run(path, setup=...).")
    if channels is None and format_of(path) is RUN:
        # of an hour only the part with the motion is read
        return Run(read_for_processing(path), setup)
    mapped = None if channels is None else parse_channel_map(channels)
    return Run(read_recording(path, channels=mapped, rate_hz=rate_hz), setup)


def process(
    run: Run,
    *,
    correction: str | None = None,
    geometry: str | None = None,
    progress: Callable[[float], None] | None = None,
    session: Sequence[Result] = (),
) -> Result:
    """Turn a run into path lengths, track, bounces and g, as `radargui process` does; nothing is written.

    Parameters
    ----------
    run
        See `open_run`.
    correction
        Instead of the setup's: joint, flights, adaptive, published, ellipse, none, or the name of a plug-in.
    geometry
        Instead of the setup's: exact, plane.
    progress
        Called with the share done, 0 to 1; what it raises ends the work.

    Raises
    ------
    RadarGuiError
        The recording does not fit the setup, or a value is not allowed.
    """
    changes = {"processing.correction": correction, "processing.geometry": geometry}
    setup = changed(run.setup, changes, "process")
    details = {f"run {number}": one.details for number, one in enumerate(session, 1)}
    before = [
        RunLikelihood(name, one.setup, one.setup_likelihood, one.setup_prior is not None and not one.setup_prior.used)
        for name, one in details.items()
        if one.setup_likelihood is not None
    ]
    others = known_setup(before, (), setup)
    return Result(process_recording(run.recording, setup, progress, others=others))


def series(*sessions: str | Path, model: str | None = None) -> Findings:
    """Return what sessions found, as the report and the panel Series say it.

    Parameters
    ----------
    sessions
        Their folders; runs without a result are processed first.
    model
        Of e against the speed that e is brought to one speed by; None: the one that describes it best.

    Returns
    -------
    Findings
        `sessions` have mean, scatter and `distribution` of e; `samples` the `fits` of all laws and the `dependences` on
        angle, diameter and number of the drop.

    Raises
    ------
    RadarGuiError
        A folder is no session, or there is no such law.
    """
    # what draws a report is not needed before
    from radargui.processing.result_of_run import stored_or_computed
    from radargui.report.facts import report_facts
    from radargui.report.report import study_session

    if model is not None:
        speed_model(model)
    opened = [Session.open(Path(one), write=False) for one in sessions]
    return report_facts([study_session(one, stored_or_computed) for one in opened], "", model).findings


def _view(package: str) -> Any:
    try:
        return importlib.import_module(package)
    except ModuleNotFoundError as error:
        raise RadarGuiError(f"This view needs {package}", remedy="Install radargui[views].") from error
