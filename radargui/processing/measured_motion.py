"""What the way from conditioned signals to a track ends in, whatever the correction; how much of it is done."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.correction.quality import WEAK, is_weak
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.channel_quality import UnexplainedStretch
from radargui.model.finding import Finding, refuse
from radargui.model.front_end import FrontEndPrior
from radargui.model.result import Bounces, CorrectedIQ, Kinematics, PathLengths, Track
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior
from radargui.model.setup_posterior import SetupLikelihood, SetupValue
from radargui.model.uncertainty_budget import InputChange
from radargui.physics.path_length import (
    MIN_RECEIVERS,
    locate_exact,
    locate_plane,
    place_antennas,
    position_uncertainty,
)
from radargui.physics.scattering import path_delay
from radargui.restitution.flight_test import FlightTest
from radargui.signals.conditioned import Conditioned

if TYPE_CHECKING:
    # only who asks for it pays for loading it
    from radargui.estimation.joint import JointEstimate
    from radargui.estimation.motion_estimate import MotionEstimate


def locate_body(paths: PathLengths, setup: Setup) -> tuple[PathLengths, Track | None]:
    """Return the paths to the sphere's centre, and the track, from paths as their phase was measured.

    Where the setup gives the polarisation, the phase that the sphere scatters with is taken off the direct path, and
    what a container's walls delay, in one step: it changes by a thousandth of what the place does. What it does to
    mirrored paths stays.
    """
    track, delay = locate(paths, setup), path_delay(setup)
    if track is None or delay is None:
        return paths, track
    # where not all receivers know their path the place is unknown, and so is the delay
    change_m = paths.change_m - np.nan_to_num(delay.at(track.position_m))
    paths = replace(paths, change_m=change_m)
    return paths, locate(paths, setup)


def locate(paths: PathLengths, setup: Setup) -> Track | None:
    """Return the positions of the sphere's centre.

    Parameters
    ----------
    paths
        Change of path length of every receiver.
    setup
        Antennas of as many receivers, where the sphere hangs at rest, and the geometry: exact (bistatic) or plane (far
        field).

    Returns
    -------
    Track or None
        None with fewer than three receivers.
    """
    if setup.n_receivers < MIN_RECEIVERS:
        return None
    # an invalid path would pull the place without a sign of it
    position = place_at(np.where(paths.valid, paths.change_m, np.nan), setup)
    # linear propagation of u(L_i) through the inverse of the rows dL_i/dp (GUM 5.1.2)
    u = position_uncertainty(position, paths.u_m, place_antennas(setup))
    return Track(paths.time_s, position, u, np.asarray(np.isfinite(position).all(axis=0)), setup.processing.geometry)


def place_at(change_m: FloatArray, setup: Setup) -> FloatArray:
    """Return the places (3, n) at changes of the paths (n_receivers, n); NaN for NaN, setup as above."""
    solve = locate_plane if setup.processing.geometry == "plane" else locate_exact
    # changes of path count from the release: there the antennas' geometry fixes L itself
    return solve(change_m, place_antennas(setup), np.array(setup.tracer.release_position_m))


def paths_of(estimate: MotionEstimate, setup: Setup) -> PathLengths:
    """Return an estimate's path lengths, with their phases."""
    # phase = 2 pi L / wavelength: estimates are in metres, the corrected IQ is shown in rad (method 1)
    phase = estimate.change_m * _rad_per_m(setup)
    return PathLengths(estimate.time_s, phase, estimate.change_m, estimate.u_change_m, estimate.valid)


def corrected_of(estimate: MotionEstimate, setup: Setup) -> CorrectedIQ:
    """Return an estimate's corrected IQ."""
    samples = estimate.time_s, estimate.i, estimate.q, estimate.valid, estimate.u_change_m * _rad_per_m(setup)
    return CorrectedIQ(*samples, estimate.method, estimate.channels, decisions=estimate.choices)


def _rad_per_m(setup: Setup) -> float:
    return 2.0 * np.pi / setup.radar.wavelength_m


def track_of(estimate: MotionEstimate, paths: PathLengths, setup: Setup) -> Track | None:
    """Return an estimate's own places; by the far field, and where it has none, those of its paths."""
    if setup.processing.geometry == "plane" or estimate.position_m is None or estimate.u_position_m is None:
        return locate(paths, setup)
    valid = np.asarray(estimate.valid.all(axis=0) & np.isfinite(estimate.position_m).all(axis=0))
    return Track(estimate.time_s, estimate.position_m, estimate.u_position_m, valid, "exact")


Report = Callable[[float], None]

_OF_REST = 0.8
"""Share of what is left of the bar that an attempt takes. Nobody knows whether one is the last: most runs need one."""


class Progress:
    """The share done of a run, which only grows.

    Parameters
    ----------
    report
        Called with the share done, 0 to 1, each time something is done, whether it grew or not: what it raises, as
        `CancelledError`, ends the work. None: nobody wants to know.
    """

    def __init__(self, report: Report | None) -> None:
        self._report = report or (lambda _: None)
        self._done = 0.0

    def reach(self, share: float) -> None:
        """Say that this share of all is done."""
        self._done = max(self._done, share)
        self._report(self._done)

    def attempt(self, share: float = _OF_REST) -> Report:
        """Return what is called with the share of an attempt that is done, 0 to 1.

        It begins where the last one has come to: an estimate that is made again, without a receiver or without some
        milliseconds, with a prior, or by a simpler method instead. It takes a share of what is left of the bar.
        """
        begin = self._done
        span = share * (1.0 - begin)
        return lambda share: self.reach(begin + span * share)


@dataclass(frozen=True, slots=True)
class MeasuredMotion:
    """Corrected IQ, path lengths and track of conditioned signals.

    Attributes
    ----------
    corrected, paths
        Of all receivers.
    track
        None with fewer than three receivers.
    bounces
        Where the estimate holds them itself; None: to be found from the track.
    changes
        What they change by with each uncertain input of the setup, where the estimate knows it itself.
    motion
        Velocities and accelerations, where the estimate knows them.
    front_end_prior
        What was known about the front ends, and whether it was used.
    setup_posterior
        What the recording says of the setup's values; empty where it says nothing.
    setup_likelihood, setup_prior
        What it says of them alone, and what other runs said of them and whether it was used; None: nothing.
    findings
        What was found on the way.
    estimate, flights
        The joint estimate, and what its flights say; None, and nothing, of other corrections.
    unexplained
        What no motion explains and has to be left out before anything of this counts.
    """

    corrected: CorrectedIQ
    paths: PathLengths
    track: Track | None
    bounces: Bounces | None = None
    changes: tuple[InputChange, ...] | None = None
    motion: Kinematics | None = None
    front_end_prior: FrontEndPrior | None = None
    setup_posterior: tuple[SetupValue, ...] = ()
    setup_likelihood: SetupLikelihood | None = None
    setup_prior: SetupPrior | None = None
    findings: tuple[Finding, ...] = ()
    estimate: JointEstimate | None = None
    flights: FlightTest = field(default_factory=FlightTest)
    unexplained: tuple[UnexplainedStretch, ...] = ()

    @property
    def rejected(self) -> BoolArray:
        """Which receivers are rejected, shape (n_receivers,)."""
        return np.array([channel.verdict == "rejected" for channel in self.corrected.channels], dtype=np.bool_)

    def said(self, *findings: Finding | None) -> MeasuredMotion:
        """Return it with what was found besides."""
        return replace(self, findings=(*self.findings, *(one for one in findings if one is not None)))

    def contradicted(self, cause: Finding | None) -> MeasuredMotion:
        """Return it with what of the setup is likely wrong; what was refused is by that. None: nothing is."""
        if cause is None:
            return self
        motion = self.refused(cause, self.rejected) if self.rejected.any() else self
        return replace(motion, flights=replace(self.flights, cause=cause))

    def blamed(self, codes: Sequence[str], cause: Finding) -> MeasuredMotion:
        """Return it with receivers that were rejected by some findings rejected by another one."""
        wrong = [one.finding is not None and one.finding.code in codes for one in self.corrected.channels]
        refused = [one.verdict == "rejected" for one in self.corrected.channels]
        return self.refused(cause, np.array(wrong, dtype=np.bool_) & refused) if any(wrong) else self

    def refused(self, finding: Finding, receivers: BoolArray | None = None) -> MeasuredMotion:
        """Return it with receivers, shape (n_receivers,), rejected by a finding; None: all of them.

        A receiver that is hardly heard is rejected for that: whatever else does not fit would need a signal to be told.
        """
        finding = replace(finding, severity="refuse")
        wrong = np.ones(len(self.corrected.channels), dtype=np.bool_) if receivers is None else receivers
        rows = zip(self.corrected.channels, wrong, strict=True)
        channels = tuple(
            replace(own, finding=refuse(WEAK) if is_weak(own) else finding) if is_wrong else own
            for own, is_wrong in rows
        )
        return replace(self, corrected=replace(self.corrected, channels=channels))


def nothing_measured(conditioned: Conditioned, method: str) -> MeasuredMotion:
    """Return the motion of no receiver at all: every one has a fault."""
    nothing, never = np.empty((0, conditioned.n_samples)), np.empty((0, conditioned.n_samples), dtype=np.bool_)
    time_s = conditioned.time_s
    corrected = CorrectedIQ(time_s, nothing, nothing, never, nothing, method, ())
    return MeasuredMotion(corrected, PathLengths(time_s, nothing, nothing, nothing, never), None)
