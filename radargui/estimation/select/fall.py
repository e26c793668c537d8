"""Turn the flights of a drop into initial values of the joint estimate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.flights.drop_model import wave_gain
from radargui.estimation.flights.estimate import DROP, DropEstimate, echo_turns_hz
from radargui.estimation.forward.bins import BINS, BinnedData, bin_by_fringe
from radargui.estimation.forward.parameters import Layout, ReceiverConstants, of_mirror
from radargui.estimation.forward.signal_model import ModelInputs
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.signals import ScaledSignals
from radargui.estimation.solve.changed_problem import problem_with_flights
from radargui.estimation.solve.initial_problem import first_motion, initial_problem
from radargui.estimation.solve.minimise import solved_at
from radargui.estimation.solve.priors import PRIORS
from radargui.estimation.solve.problem import Start, State
from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup
from radargui.motion.flights import Flights
from radargui.physics.mirrors import MirrorPlane
from radargui.physics.path_length import path_lengths

_MIN_FLIGHT_S = 0.010
"""A shorter flight is none that a spline could follow: the body lies."""


@dataclass(frozen=True, slots=True)
class FoundFall:
    """A drop as its flights have measured it, prepared for the joint estimate.

    Attributes
    ----------
    estimate
        Converged.
    signals, data
        The samples; bins, broken at the impacts, and geometry.
    flights
        All flights of the record: after the last one that was followed the body bounces on with the same e.
    lies_s
        Time from which on the body keeps its height.
    break_s
        Times of the impacts and of coming to rest, shape (n_breaks,).
    """

    estimate: DropEstimate
    signals: ScaledSignals
    data: BinnedData
    flights: Flights
    lies_s: float
    break_s: FloatArray

    @staticmethod
    def of(estimate: DropEstimate, signals: ScaledSignals, setup: Setup) -> FoundFall:
        """Return the drop with bins for the joint estimate."""
        time_s = signals.time_s
        flights, lies_s = _bounced_on(estimate.flights, estimate.end_s, float(time_s[-1]))
        breaks = flights.impact_s
        if lies_s < time_s[-1] - _MIN_FLIGHT_S:
            breaks = np.append(breaks, lies_s)
        values = estimate.at.values._replace(flights=flights.unknowns)
        # as fine as a joint estimate's bins are elsewhere, finer where the floor asks for it
        finer = BINS.per_fringe / DROP.bins.per_fringe
        turns_hz = echo_turns_hz(estimate.model, values, time_s, finer) * (time_s < lies_s)
        bins = bin_by_fringe(signals, time_s, turns_hz, signals.rest_end_s, breaks, DROP.bins)
        # where the setup does not tell polarisations the flights have found them
        data = replace(BinnedData.of(bins, signals, setup), sphere=estimate.model.sphere)
        return FoundFall(estimate, signals, data, flights, lies_s, breaks)

    @property
    def fringes(self) -> FloatArray:
        """How many each receiver saw, shape (n_receivers,)."""
        paths = path_lengths(self.offset_m(self.data.bins.time_s) + self.data.release_m[:, None], self.data.antennas)
        return np.asarray(np.ptp(paths, axis=1) / self.data.wavelength_m)

    def offset_m(self, time_s: FloatArray) -> FloatArray:
        """Return places against the release, (3, n), at times (n,)."""
        out = self.flights.position_m(time_s)
        out[2, time_s > self.lies_s] = self.flights.position_m(np.array([self.lies_s]))[2]
        return np.asarray(out - self.flights.start_m[:, None])

    def starts(self, data: BinnedData, length_m: float, known: Sequence[LogFrontEnd] | None) -> list[Start]:
        """Return the problem without a floor and with the one found, motion and setup as the flights have them.

        Parameters
        ----------
        data
            All bins or fewer.
        length_m
            Correlation length of the bias maps.
        known
            What earlier runs say about the front ends.
        """
        model, theta = self.estimate.model, self.estimate.at.values.theta
        tilts_and_shift = theta[model.layout.planes]
        found = replace(model.plane, foot_m=model.plane.foot_m + tilts_and_shift[2] * model.plane.normal)
        return [self._start(data, length_m, known, planes) for planes in ((), (found,))]

    def _start(
        self,
        data: BinnedData,
        length_m: float,
        known: Sequence[LogFrontEnd] | None,
        planes: tuple[MirrorPlane, ...],
    ) -> Start:
        place = self.offset_m(data.bins.time_s) + data.release_m[:, None]
        motion = first_motion(data, place, self.signals.rest_end_s, self.break_s)
        start = initial_problem(data, motion, self._constants(), planes, length_m, known)
        carried = self._carried(start.problem.layout, start.state.theta, n_mirrors=len(planes))
        start = Start(start.problem.at_places(place, carried), State(start.state.coefficients, carried))
        # where flights explain the signals antennas and floor are right already: what bends now would stand for maps
        # that are still flat; a wall that is missing may bend it
        flying = problem_with_flights(solved_at(start), self.estimate.widening * PRIORS.off_flight_m_s2)
        if flying is None:
            return start
        layout, theta, stated = flying.problem.layout, flying.state.theta.copy(), self.estimate.model.setup
        theta[layout.flight] = 0.0, 0.0, self.flights.g_m_s2, self.flights.drag_1_m
        if data.setup is not None:
            by_key = dict(zip(stated.inputs, self.estimate.unknowns, strict=False))
            theta[layout.setup] = [by_key.get(one.key, 0.0) for one in data.setup.inputs]
        inputs = flying.problem.placed(theta).inputs
        _count_from_release(theta, layout, inputs, data.release_m)
        # the motion goes with the release: what is scattered there is not what it was at the stated one
        place = self.offset_m(data.bins.time_s) + inputs.release_m[:, None]
        return Start(flying.problem.at_places(place, theta), State(flying.state.coefficients, theta))

    def _constants(self) -> list[ReceiverConstants]:
        """Return the constants of each receiver: the wave at the release, offsets as they are on average."""
        model, at = self.estimate.model, self.estimate.at
        wave = wave_gain(model, at)[:, 0, 0, 0, 0]
        highest = int(np.argmax(model.functions[1]))
        offsets = at.coefficients[:, model.linear.offsets]
        mean = np.stack([offsets[:, 0::2], offsets[:, 1::2]], axis=1) @ model.functions.mean(axis=1)
        theta = at.values.theta
        return [
            ReceiverConstants(
                phase_rad=float(np.angle(one[highest])),
                log_amplitude=float(np.log(np.abs(one[highest]))),
                offset_i=float(i),
                offset_q=float(q),
                log_gain=float(theta[own.log_gain]),
                quadrature_error_rad=float(theta[own.quadrature_error]),
            )
            for one, (i, q), own in zip(wave, mean, model.layout.receivers, strict=True)
        ]

    def _carried(self, layout: Layout, theta: FloatArray, *, n_mirrors: int) -> FloatArray:
        """Return theta with lobes, polarisations, crosstalk and, with a mirror, what it reflects, as found."""
        old, was, out = self.estimate.model.layout, self.estimate.at.values.theta, theta.copy()
        names = ["transmitter_lobe", "polarization", "crosstalk"]
        own_names = ["receiver_lobe", "polarization"]
        if n_mirrors:
            names += ["transmitter_reflection", "exchange", "edges"]
            own_names += ["receiver_reflection", "double_reflection"]
            # the shift is in the plane's foot
            out[layout.planes.start : layout.planes.start + 2] = was[old.planes.start : old.planes.start + 2]
        for name in names:
            out[getattr(layout, name)] = was[getattr(old, name)]
        for now, before in zip(layout.receivers, old.receivers, strict=True):
            for name in own_names:
                out[getattr(now, name)] = was[getattr(before, name)]
        return out


def _count_from_release(theta: FloatArray, layout: Layout, inputs: ModelInputs, stated_m: FloatArray) -> None:
    """Let phases, T, R and X, which count from the stated release in flights, count from the one that was found."""

    def further(antenna_m: FloatArray) -> float:
        at = np.linalg.norm(np.stack([inputs.release_m, stated_m]) - antenna_m, axis=1)
        return inputs.wavenumber * float(at[0] - at[1])

    def turn(places: slice, phase_rad: float) -> None:
        turned = complex(*theta[places]) * np.exp(1j * phase_rad)
        theta[places] = turned.real, turned.imag

    transmitter_m, unknown = inputs.antennas.transmitter_m, layout.plane_unknowns(theta)
    direct = further(transmitter_m)
    sent = [
        further(plane.image(transmitter_m, own)) - direct for plane, own in zip(inputs.planes, unknown, strict=True)
    ]
    for mirror, phase_rad in enumerate(sent):
        turn(of_mirror(layout.transmitter_reflection, mirror), phase_rad)
    for places, receiver_m in zip(layout.receivers, inputs.antennas.receivers_m, strict=True):
        back = further(receiver_m)
        theta[places.phase] += direct + back
        for mirror, (plane, own) in enumerate(zip(inputs.planes, unknown, strict=True)):
            over = further(plane.image(receiver_m, own)) - back
            turn(of_mirror(places.receiver_reflection, mirror), over)
            turn(of_mirror(places.double_reflection, mirror), sent[mirror] + over)


def _bounced_on(flights: Flights, lost_s: float, end_s: float) -> tuple[Flights, float]:
    """Return flights with the further ones that these let expect, and when the body comes to rest.

    A single flight ends where it was lost.
    """
    if flights.impact_s.size == 0:
        return flights, lost_s
    before, after = -flights.velocity_before_m_s()[-1, 2], flights.velocity_m_s[-1, 2]
    share = min(float(after / before), 1.0)
    velocity, impacts = [*flights.velocity_m_s], [*flights.impact_s]
    while True:
        lands_s = float(impacts[-1] + 2.0 * velocity[-1][2] / flights.g_m_s2)
        slower = velocity[-1] * np.array([1.0, 1.0, share])
        is_last = 2.0 * slower[2] / flights.g_m_s2 < _MIN_FLIGHT_S
        if is_last or lands_s > end_s - _MIN_FLIGHT_S:
            return replace(flights, velocity_m_s=np.array(velocity), impact_s=np.array(impacts)), lands_s
        impacts.append(lands_s)
        velocity.append(slower)
