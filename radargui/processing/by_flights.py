"""The way of the flights: a drop measured as what it is, a fall and the flights after it (method 4, Flights first)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.flights.estimate import DropEstimate, estimate_drop
from radargui.estimation.flights.other_diameter import OtherDiameter, other_diameter
from radargui.estimation.flights.readout import drop_kinematics, drop_motion, place_changes
from radargui.estimation.flights.start import START, DropStart
from radargui.estimation.hardware import as_prior
from radargui.estimation.posterior.unexplained import Residuals, unexplained_stretches
from radargui.estimation.signals import ScaledSignals, remaining, scaled_signals
from radargui.model.assumed import DIAMETER
from radargui.model.errors import ProcessingError, SolveError
from radargui.model.finding import Finding, error_of, refuse, warn
from radargui.model.front_end import FrontEndPrior
from radargui.model.result import whole_milliseconds
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.processing.checks.estimate import gained_by_polarization, is_blamed
from radargui.processing.measured_motion import MeasuredMotion, corrected_of, paths_of, track_of
from radargui.restitution.drop_bounces import drop_bounces, drop_changes
from radargui.restitution.setup_outlier import wrong_value
from radargui.signals.conditioned import Conditioned

MAX_CHI_SQUARE = 2.0
"""Of residuals averaged over 5 ms: above it more than noise is left, and uncertainties that are widened by it are a
guess (method 6, Quality)."""

MAX_PULL = 4.0
"""Of a value of the setup from what is stated, in its u: one of 16 000 is farther off by chance."""

UNCHANGED = 0.8
"""Share of such residuals that stays where another size of the sphere has nothing to do with them."""


STRONG = 0.5
"""|R| of a floor from which on circles say nothing of wires: the waves over it nearly cancel the direct one."""


@dataclass(frozen=True, slots=True)
class MeasuredDrop:
    """A drop by its flights.

    Attributes
    ----------
    motion
        Corrected IQ, path lengths, track and bounces.
    estimate, signals
        What it was found by, in which samples.
    """

    motion: MeasuredMotion
    estimate: DropEstimate
    signals: ScaledSignals

    def other_diameter(self, setup: Setup, motion: MeasuredMotion) -> OtherDiameter | None:
        """Return the size of the sphere that the flights like better, where something of a motion would be blamed."""
        # a receiver's gain and angle stand for a part of what a sphere of another size scatters
        return other_diameter(self.estimate, setup) if is_blamed(motion, setup) else None

    def wrong_diameter(self, other: OtherDiameter, setup: Setup, motion: MeasuredMotion) -> Finding | None:
        """Return that the sphere's diameter is likely wrong, where the flights tell it."""
        gain = other.gain / max(1.0, float(other.block_chi_square.mean()))
        unexplained, beyond = (
            max(float(each.max()) - MAX_CHI_SQUARE, 0.0)
            for each in (self.estimate.block_chi_square, other.block_chi_square)
        )
        left = beyond / unexplained if unexplained else 0.0
        # a wrong angle of an antenna, too, is less so with another size: where a place explains all that bends, the
        # joint estimate with that size has to tell
        if motion.flights.is_explained or gain < gained_by_polarization(motion):
            return None
        # what no size changes is something else's: a wall's, which flights do not place
        left = 0.0 if left > UNCHANGED else left
        return wrong_value(DIAMETER, other.by_m, gain, left, setup)

    @property
    def strong_floor(self) -> Finding | None:
        """What is to blame where nothing stands and the floor that the flights met reflects strongly; else None."""
        share = _reflection(self.estimate)
        if self.estimate.flights.impact_s.size == 0 or share < STRONG:
            return None
        return refuse("strong_floor", share=share)

    @property
    def landed_dead(self) -> Finding | None:
        """That the fall ended without a rebound to be seen, and below which its e would be; else None."""
        flights, landed_s = self.estimate.flights, self.estimate.start.landed_s
        if landed_s is None:
            return None
        speed_m_s = -float(flights.velocity_at(np.array([landed_s]))[2, 0])
        return warn(
            "landed_dead", at_s=landed_s, least_m_s=START.min_rebound_m_s, most_e=START.min_rebound_m_s / speed_m_s
        )

    @property
    def is_explained(self) -> bool:
        """Whether its flights explain the signals to its end."""
        return self.is_followed and not _is_misfit(self.estimate)

    @property
    def is_followed(self) -> bool:
        """Whether it was followed to its end, also where something else is in the signals: a wall, mostly."""
        return self.estimate.start.why is None


def measure_by_flights(
    conditioned: Conditioned,
    setup: Setup,
    progress: Callable[[float], None],
    prior: FrontEndPrior | None,
    begun: DropStart | None = None,
) -> MeasuredDrop:
    """Return a drop by its flights.

    Parameters
    ----------
    conditioned
        Signals, rest, noise of three or four receivers.
    setup
        What it states is a measurement, too: antennas, release and wavelength are found anew within their u.
    progress
        Called with the share done, 0 to 1; what it raises ends the work.
    prior
        What is known about the front ends, as they are wired; None where nothing is.
    begun
        How it was begun before stretches were left out: an impact may lie in one.

    Raises
    ------
    ProcessingError
        Nothing falls from a rest at the release, or it cannot be followed to its first flight.
    """
    if conditioned.n_receivers < MIN_RECEIVERS:
        raise error_of(ProcessingError, "flights_need_three_receivers")
    taken_off = scaled_signals(conditioned)
    # a strong floor makes a mixer look far off, which flights can tell; with it taken off no crosstalk can be found
    signals = scaled_signals(conditioned, lambda _: None) if any(taken_off.mixers) else taken_off
    if not signals.has_rest:
        raise error_of(ProcessingError, "starts_in_motion")
    done = 0

    def watch() -> None:
        nonlocal done
        done += 1
        # nobody knows how many steps there will be: typically forty
        progress(0.95 * (1.0 - float(np.exp(-done / 40.0))))

    def estimated(signals: ScaledSignals) -> DropEstimate | Finding:
        known = None
        if prior is not None:
            wired = tuple(front_end.with_phase_sign(setup.radar.phase_sign) for front_end in prior.front_ends)
            known = as_prior(remaining(wired, signals))
        found = estimate_drop(signals, setup, front_ends=known, begun=begun, watch=watch)
        # what was left out may have led astray how it was begun, too
        if begun is not None and (isinstance(found, Finding) or _findings(found)):
            found = estimate_drop(signals, setup, front_ends=known, watch=watch)
        return found

    try:
        estimate = estimated(signals)
        # mixers that are far off indeed have to be taken off first
        if any(taken_off.mixers) and (isinstance(estimate, Finding) or estimate.has_far_mixer):
            signals = taken_off
            estimate = estimated(signals)
        if isinstance(estimate, Finding):
            raise error_of(ProcessingError, estimate.code, **estimate.facts)
        changes = place_changes(estimate)
    # a matrix without inverse says that the signal holds too little; every other fault is one
    except np.linalg.LinAlgError as error:
        raise error_of(SolveError, "no_solution", error=str(error)) from error
    motion = drop_motion(estimate, signals, changes)
    if any(one.verdict == "rejected" for one in motion.channels):
        raise error_of(ProcessingError, "flights_explain_little")
    paths, bounces = paths_of(motion, setup), drop_bounces(estimate, setup)
    used = None if prior is None else replace(prior, used=True)
    moved = drop_changes(estimate, bounces, changes, setup)
    found = MeasuredMotion(
        corrected_of(motion, setup),
        paths,
        track_of(motion, paths, setup),
        bounces,
        moved,
        drop_kinematics(estimate, whole_milliseconds(estimate.flights.onset_s, estimate.end_s)),
        used,
        findings=_findings(estimate),
        unexplained=unexplained_stretches(Residuals.of_drop(estimate)),
    )
    return MeasuredDrop(found, estimate, signals)


def _reflection(estimate: DropEstimate) -> float:
    return float(np.hypot(*estimate.at.values.theta[estimate.model.layout.transmitter_reflection]))


def _findings(estimate: DropEstimate) -> tuple[Finding, ...]:
    found = []
    # what explains the signals so may be something else than the setup: a plate that nobody stated
    if (pull := estimate.max_pull) > MAX_PULL:
        found.append(warn("flights_pulled", times_u=pull, is_unstated=estimate.model.plane.surface is None))
    if _is_misfit(estimate):
        misfit = float(estimate.block_chi_square.max())
        found.append(warn("flights_misfit", misfit=misfit, is_strong=_reflection(estimate) >= STRONG))
    if estimate.start.why is not None:
        found.append(warn("flights_end_early", cause=estimate.start.why))
    return tuple(found)


def _is_misfit(estimate: DropEstimate) -> bool:
    return float(estimate.block_chi_square.max()) > MAX_CHI_SQUARE
