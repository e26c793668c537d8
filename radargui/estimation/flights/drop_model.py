"""What all channels show of a drop whose flights, antennas and floor are unknown (method 4, Flights first).

The physics is that of `estimation/forward`; what it is linear in is solved for in between (variable projection: Golub &
Pereyra 1973, with the derivatives of Kaufman 1975).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from radargui.estimation.flights.linear_part import LinearPart
from radargui.estimation.flights.setup_unknowns import StatedSetup
from radargui.estimation.flights.stated_plate import stated_floor
from radargui.estimation.forward.bins import Bins, Multiplexer
from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.signal_model import (
    EVERY,
    ModelInputs,
    Waves,
    harmonics_of,
    nodes_of,
    shown,
    turn_of,
    waves_at,
)
from radargui.estimation.forward.signal_slopes import receiver_slopes, setup_slopes
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.forward.sphere import PolarisedSphere
from radargui.model.arrays import BoolArray, ComplexArray, FloatArray
from radargui.motion.flights import Flights
from radargui.physics.mirrors import MirrorPlane

REBOUND_M_S, IMPACT_S = 3.0, 0.05
"""Prior deviations of each component after an impact, and of its time, against where a start found them."""


class Parts(NamedTuple):
    """The values of all unknowns.

    Attributes
    ----------
    flights
        As `FlightLayout` orders them; the start is the release.
    setup
        As `StatedSetup` orders them, shape (n_keys,).
    theta
        Floor, polarisations, crosstalk, front ends as the forward model orders them, shape (layout.size,).
    """

    flights: FloatArray
    setup: FloatArray
    theta: FloatArray


@dataclass(frozen=True, slots=True)
class DropModel:
    """The data, the prior, and all that stays the same while the unknowns are improved.

    Attributes
    ----------
    bins
        Means of the samples; `used` says which count, shape (n_bins,).
    delay_s, multiplexer
        Of each channel, shape (n_channels,), and what channels keep of each other; None where that is not looked for.
    setup, sphere, plane
        Unknowns of the setup; the sphere, None for a point; the plane near which the floor is.
    layout, linear
        What theta means; what is linear.
    mean, deviation
        Prior of the unknowns; those without a deviation are held. The setup's has its own directions.
    inputs
        What of the forward model is made once a round: ways of the amplitude and what the sphere scatters.
    functions
        Of the height fallen at the bins, the first of them one, shape (1 + n_functions, n_bins).
    aside
        How far x and y are from the release at the bins, in halves of what the heights go through: what the angle at
        which the floor is seen changes by, up and down or aside, is alike. Shape (2, n_bins).
    heights_m
        Highest and lowest place of the bins that these functions were made for: between them they go from -1 to 1.
    noise
        By which the noise of each receiver's bins is larger, shape (n_receivers,).
    min_sigma
        No bin counts as better known, in amplitudes.
    scattered
        Deviations of what else reflects and of an uneven floor, in each receiver, shape (n_receivers, 2).
    turn
        Phase (rad) at which each receiver's amplitude was, which tells a change of it from a change of phase.
    drift
        Of the channels as their rest shows it; a start looks at too little of the record for it.
    slow
        Functions of time at the bins that carry it, with coefficients N(0, 1), shape (n_channels, n_bins, n_slow).
    """

    bins: Bins
    used: BoolArray
    delay_s: FloatArray
    multiplexer: Multiplexer | None
    setup: StatedSetup
    sphere: PolarisedSphere | None
    plane: MirrorPlane
    layout: Layout
    linear: LinearPart
    mean: Parts
    deviation: Parts
    inputs: ModelInputs
    functions: FloatArray
    aside: FloatArray
    heights_m: tuple[float, float]
    noise: FloatArray
    min_sigma: float
    turn: FloatArray
    scattered: FloatArray
    drift: Drift
    slow: FloatArray

    @property
    def linear_deviations(self) -> FloatArray:
        """Prior deviations of what is linear, shape (n_receivers, n_columns)."""
        return self.linear.deviations(self.scattered)

    @property
    def of_floor(self) -> FloatArray:
        """Functions of the place for each way over the floor, shape (n_floor, n_bins)."""
        return np.concatenate([self.functions[1 : 1 + self.linear.n_uneven], self.aside])[: self.linear.n_floor]

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return self.delay_s.size // 2

    @property
    def flights(self) -> slice:
        """Where flights stand among all values."""
        return slice(0, self.mean.flights.size)

    @property
    def stated(self) -> slice:
        """Where the setup's values stand among all."""
        return slice(self.flights.stop, self.flights.stop + self.mean.setup.size)

    @property
    def free(self) -> BoolArray:
        """Which values but the setup's are unknown, shape (n_values,)."""
        return np.concatenate([self.deviation.flights, np.zeros(self.mean.setup.size), self.deviation.theta]) > 0.0

    @property
    def n_unknowns(self) -> int:
        """Length of the vector of unknowns: those of the setup's directions, then the free ones in order."""
        return len(self.setup.directions) + int(self.free.sum())

    def values(self, unknowns: FloatArray) -> Parts:
        """Return all values of unknowns (n_unknowns,), which count in deviations from the prior."""
        n_stated, free = len(self.setup.directions), self.free
        stated = self.mean.setup + unknowns[:n_stated] @ self.setup.directions
        step = np.zeros(free.size)
        step[free] = unknowns[n_stated:]
        flights = self.mean.flights + step[self.flights] * self.deviation.flights
        flights[1:4] = stated[self.setup.release]
        return Parts(flights, stated, self.mean.theta + step[self.stated.stop :] * self.deviation.theta)

    def unknowns(self, values: Parts) -> FloatArray:
        """Return the unknowns of some values, those of the setup as near as their directions allow."""
        moved = values.setup - self.mean.setup
        stated = np.linalg.lstsq(self.setup.directions.T, moved, rcond=None)[0]
        deviation = np.concatenate([self.deviation.flights, np.ones(moved.size), self.deviation.theta])
        change = np.concatenate([values.flights, values.setup, values.theta]) - np.concatenate(self.mean)
        return np.concatenate([stated, (change / np.where(deviation > 0.0, deviation, 1.0))[self.free]])

    def by_unknowns(self, columns: FloatArray) -> FloatArray:
        """Return derivatives by the unknowns, (..., n_unknowns), of those by all values, (..., n_values)."""
        by_stated = columns[..., self.stated].copy()
        by_stated[..., self.setup.release] += columns[..., 1:4]
        deviation = np.concatenate([self.deviation.flights, np.ones(self.mean.setup.size), self.deviation.theta])
        own = columns[..., self.free] * deviation[self.free]
        return np.concatenate([by_stated @ self.setup.directions.T, own], axis=-1)

    def node_times(self) -> FloatArray:
        """Return the times of the nodes of every channel's bins, shape (n_channels, 2, n_bins)."""
        nodes = self.bins.time_s + np.array([-1.0, 1.0])[:, None] * self.bins.node_s
        return self.delay_s[:, None, None] + nodes

    def of_bins(self, bins: Bins, values: Parts, *, foretold: bool = False) -> DropModel:
        """Return it with other bins of the same samples, renewed there.

        What is `foretold` by coefficients that were found in its own bins keeps the functions' heights.
        """
        none = np.zeros((bins.n_bins, 0))
        drift = np.zeros((self.delay_s.size, bins.n_bins, 0))
        inputs = replace(self.inputs, bias=none, amplitude_map=none, drift=drift)
        heights, slow = self.heights_m if foretold else None, self.drift.uncorrelated(bins)
        linear = replace(self.linear, n_slow=slow.shape[2])
        used = np.ones(bins.n_bins, np.bool_)
        return replace(self, bins=bins, used=used, inputs=inputs, linear=linear, slow=slow).renewed(values, heights)

    def with_flight(self, values: Parts, impact_s: float, velocity_m_s: FloatArray) -> tuple[DropModel, Parts]:
        """Return it and the values with one more flight after an impact, about which the prior says little."""
        split = Flights.of(values.flights).layout.impacts.start

        def longer(old: FloatArray, velocity: FloatArray, at_s: float) -> FloatArray:
            return np.concatenate([old[:split], velocity, old[split:], [at_s]])

        deviation = longer(self.deviation.flights, np.full(3, REBOUND_M_S), IMPACT_S)
        mean = longer(self.mean.flights, velocity_m_s, impact_s)
        model = replace(
            self, mean=self.mean._replace(flights=mean), deviation=self.deviation._replace(flights=deviation)
        )
        return model, values._replace(flights=longer(values.flights, velocity_m_s, impact_s))

    def renewed(self, values: Parts, heights_m: tuple[float, float] | None = None) -> DropModel:
        """Return it with ways, scattering and functions as the flights have them, for another round.

        Of the heights of its own bins where none are given.
        """
        position = Flights.of(values.flights).position_m(self.bins.time_s)
        antennas, release = self.setup.antennas(values.setup), self.mean.setup[self.setup.release]
        sphere = None
        if self.sphere is not None:
            sphere = self.sphere.fields(position, antennas, release, (self.plane,), values.theta[self.layout.mirrors])
        inputs = replace(
            self.inputs,
            range_factor=self.inputs.on_the_way(position, antennas, release),
            sphere=sphere,
        )
        height = position[2]
        top, lowest = heights_m or (float(height.max()), float(height[self.used].min()))
        through_m = max(top - lowest, 1e-3)
        fallen = np.clip((height - top) / through_m, -1.0, 0.0)
        functions = np.polynomial.legendre.legvander(2.0 * fallen + 1.0, self.linear.n_functions)
        aside = (position[:2] - release[:2, None]) / (0.5 * through_m)
        return replace(self, inputs=inputs, functions=functions.T, aside=aside, heights_m=(top, lowest))


@dataclass(frozen=True, slots=True)
class Evaluation:
    """The model at some values, what is linear solved for.

    Attributes
    ----------
    values
        Of all unknowns.
    waves, node_m
        At the nodes.
    basis
        Columns of what is linear, shape (n_receivers, 2, n_bins, n_columns).
    coefficients
        Shape (n_receivers, n_columns).
    excess
        What the channel before is more, shape (n_receivers, 2, n_bins).
    value
        What the channels should show, same shape.
    residual
        Data less that, in standard deviations of the measured noise, same shape.
    weight
        Of the squared residuals in units of the noise scale: robust, 0 where a bin does not count; shape (n_receivers,
        n_bins).
    """

    values: Parts
    waves: Waves
    node_m: FloatArray
    basis: FloatArray
    coefficients: FloatArray
    excess: FloatArray
    value: FloatArray
    residual: FloatArray
    weight: FloatArray

    @property
    def misfit(self) -> FloatArray:
        """Mean of the squares of both channels, shape (n_receivers, n_bins)."""
        return np.asarray((self.residual**2).mean(axis=1))


_BEND = 3.0  # deviations from which on the robust loss grows as the residual, not its square (pseudo-Huber)


def robust_weight(model: DropModel, misfit: FloatArray) -> FloatArray:
    """Return the weights of bins with misfits (n_receivers, n_bins): (1 + misfit / bend^2)^-1/2."""
    scaled = misfit / model.noise[:, None] ** 2
    return np.asarray(model.used / np.sqrt(1.0 + scaled / _BEND**2))


def robust_cost(model: DropModel, unknowns: FloatArray, at: Evaluation) -> float:
    """Return half the sum of squares under the robust loss, the prior's of unknowns and coefficients too."""
    scaled = at.misfit / model.noise[:, None] ** 2
    data = (model.used * 2.0 * _BEND**2 * (np.sqrt(1.0 + scaled / _BEND**2) - 1.0)).sum() * 2.0
    linear = ((at.coefficients / model.linear_deviations) ** 2).sum()
    residual, _ = stated_floor(model, at.values, _inputs_at(model, at.values))
    return 0.5 * float(data + linear + unknowns @ unknowns + residual @ residual)


def sigma_of(model: DropModel) -> FloatArray:
    """Return the noise of the bins, shape (n_receivers, 2, n_bins)."""
    sigma = model.bins.sigma.reshape(model.n_receivers, 2, -1)
    return np.asarray(np.maximum(sigma, model.min_sigma))


def evaluate(
    model: DropModel,
    unknowns: FloatArray,
    weight: FloatArray | None = None,
    coefficients: FloatArray | None = None,
) -> Evaluation:
    """Return the model at some unknowns, (n_unknowns,); weights as in `Evaluation`, else all alike.

    Coefficients of what is linear are solved for, or held where they are given.
    """
    values = model.values(unknowns)
    times = model.node_times()
    inputs = _inputs_at(model, values)
    place = Flights.of(values.flights).position_m(times.ravel()).reshape(3, *times.shape)
    node_m = nodes_of(place)
    waves = waves_at(node_m, values.theta, model.layout, inputs, EVERY)
    basis = basis_of(model, waves, values.theta)
    sigma = sigma_of(model)
    weight = np.broadcast_to(1.0 * model.used, sigma[:, 0].shape) if weight is None else weight
    excess = np.zeros(sigma.shape)
    if coefficients is not None:
        value = (basis @ coefficients[:, None, :, None])[..., 0]
        residual = (model.bins.value.reshape(sigma.shape) - value) / sigma
        return Evaluation(values, waves, node_m, basis, coefficients, excess, value, residual, weight)
    return _solved(model, Evaluation(values, waves, node_m, basis, _NONE, excess, _NONE, _NONE, weight))


def reweighted(model: DropModel, at: Evaluation) -> Evaluation:
    """Return an evaluation with what is linear solved for anew, by the robust weights of what it leaves."""
    return _solved(model, replace(at, weight=robust_weight(model, at.misfit)))


_NONE = np.empty(0)


def _solved(model: DropModel, at: Evaluation) -> Evaluation:
    """Return an evaluation with what is linear solved for by its weights."""
    sigma, basis = sigma_of(model), at.basis
    data = model.bins.value.reshape(sigma.shape)
    kappa = float(at.values.theta[model.layout.crosstalk.start]) if model.multiplexer is not None else 0.0
    excess = np.zeros(sigma.shape)
    scaled = np.sqrt(at.weight)[:, None] / sigma / model.noise[:, None, None]
    rows = (basis * scaled[..., None]).reshape(len(basis), -1, basis.shape[-1])
    normal = np.swapaxes(rows, 1, 2) @ rows + _diagonal(model.linear_deviations**-2.0)
    # what channels keep of each other is made of the model itself: once more with it
    for again in (False, True) if kappa else (False,):
        right = ((data - kappa * excess) * scaled).reshape(len(basis), -1, 1)
        solved = np.asarray(np.linalg.solve(normal, np.swapaxes(rows, 1, 2) @ right)[..., 0])
        value = (basis @ solved[:, None, :, None])[..., 0]
        if model.multiplexer is not None and not again:
            excess = model.multiplexer.excess(value.reshape(-1, sigma.shape[-1]), model.bins.time_s)
            excess = excess.reshape(sigma.shape)
    value = value + kappa * excess
    return replace(at, coefficients=solved, excess=excess, value=value, residual=(data - value) / sigma)


def _diagonal(rows: FloatArray) -> FloatArray:
    """Return diagonal matrices (n, k, k) of rows (n, k)."""
    return np.asarray(rows[..., None] * np.eye(rows.shape[-1]))


def _inputs_at(model: DropModel, values: Parts) -> ModelInputs:
    return replace(
        model.inputs, antennas=model.setup.antennas(values.setup), wavenumber=model.setup.wavenumber(values.setup)
    )


def basis_of(model: DropModel, waves: Waves, theta: FloatArray) -> FloatArray:
    """Return the columns of what is linear, shape (n_receivers, 2, n_bins, n_columns), of waves by theta."""
    functions = model.functions
    n_receivers, n_bins = model.n_receivers, functions.shape[1]
    columns: list[FloatArray] = []
    field = shown(waves)
    if model.linear.free_ways:
        ways = _ways(waves)
        columns += [part for way in ways for part in (way.real, -way.imag)]
        sign = _IMAGE[:, None]
        columns += [sign * part for way in ways for part in (way.real, way.imag)]
        field = ways[0]
    else:
        columns += [field.real, -field.imag]
    # a change of the amplitude is along the wave, one of the phase across it
    along = field * np.exp(1j * model.turn)[:, None, None]
    for function in functions[1:]:
        columns += [function * along.real, -function * along.imag]
    offsets, uneven, slow = model.linear.offsets, model.linear.uneven, model.linear.slow
    out = np.zeros((n_receivers, 2, n_bins, slow.stop))
    for number, column in enumerate(columns):
        out[..., number] = column
    out[:, 0, :, offsets.start : offsets.stop : 2] = functions.T
    out[:, 1, :, offsets.start + 1 : offsets.stop : 2] = functions.T
    if model.linear.n_harmonics:
        turn = turn_of(model.layout.own_values(theta, EVERY), model.layout.own)[..., None]
        # of the wave alone: its changes are some per cent
        made = np.moveaxis(turn[:, None] * harmonics_of(field, turn), 1, -1)
        out[..., offsets.stop : uneven.start : 2] = made.real
        out[..., offsets.stop + 1 : uneven.start : 2] = -made.imag
    if model.linear.n_uneven:
        every = waves.strength[..., None, :] * waves.mean
        ways = np.stack([every[:, 1, 0], every[:, 0, 1], every[:, 1, 1]], axis=-1)[..., None]
        changed = (ways * model.of_floor.T[:, None]).reshape(*ways.shape[:3], -1)
        out[..., uneven.start : uneven.stop : 2] = changed.real
        out[..., uneven.start + 1 : uneven.stop : 2] = -changed.imag
    if n_slow := model.linear.n_slow:
        drifts = model.slow.reshape(n_receivers, 2, n_bins, n_slow)
        out[:, 0, :, slow.start : slow.start + n_slow] = drifts[:, 0]
        out[:, 1, :, slow.start + n_slow :] = drifts[:, 1]
    return out


_IMAGE = np.array([1.0, -1.0])  # what the mirror image in the IQ plane, conj Z, does to I and Q of it


def _ways(waves: Waves) -> ComplexArray:
    """Return the waves of each way, with T, R and X of one, (4, n_receivers, 2, n_bins): direct, by T, R and both."""
    every = waves.scattered[..., None, :] * waves.mean
    first, second = every.shape[-4:-2]
    return np.moveaxis(every.reshape(len(every), first * second, *every.shape[-2:]), 1, 0)


def wave_gain(model: DropModel, at: Evaluation) -> ComplexArray:
    """Return what theta's waves are multiplied with, see `basis_of`: (n_receivers, ways, ways, channels, 1, n_bins)."""
    pairs = at.coefficients[:, 0::2] + 1j * at.coefficients[:, 1::2]
    n_ways = 8 if model.linear.free_ways else 1
    turn = np.exp(1j * model.turn)[:, None]
    changes = (turn * pairs[:, n_ways : n_ways + model.linear.n_functions]) @ model.functions[1:]
    n_bins = changes.shape[-1]
    if not model.linear.free_ways:
        out = np.empty((model.n_receivers, 2, 2, 1, 1, n_bins), complex)
        out[:] = (pairs[:, :1] + changes)[:, None, None, None, None]
        if n_floor := model.linear.n_floor:
            uneven = model.linear.uneven
            floor = pairs[:, uneven.start // 2 : uneven.stop // 2].reshape(len(pairs), 3, n_floor)
            by_way = floor @ model.of_floor
            for number, (sent, got) in enumerate(((1, 0), (0, 1), (1, 1))):
                out[:, sent, got, 0, 0] += by_way[:, number]
        return out
    own, image = pairs[:, :4, None], np.conj(pairs[:, 4:8, None])
    # Re h c' conj Z = +-Re h Z conj c': in I with the sign plus
    both = own + _IMAGE * image
    out = np.repeat(both.reshape(model.n_receivers, 2, 2, 2, 1, 1), n_bins, axis=-1)
    out[:, 0, 0, :, 0] += changes[:, None]
    return out


@dataclass(frozen=True, slots=True)
class NormalEquations:
    """Of the unknowns, what is linear projected out: matrix (n, n) and slope (n,), the prior's included.

    `linear_by_unknowns` is what the coefficients change by, shape (n_receivers, n_columns, n).
    """

    matrix: FloatArray
    slope: FloatArray
    linear_by_unknowns: FloatArray


def normal_equations(model: DropModel, unknowns: FloatArray, at: Evaluation) -> NormalEquations:
    """Return the Gauss-Newton equations at an evaluation, with Kaufman's derivatives of the projected residuals."""
    columns = slopes_of(model, at)
    sigma = sigma_of(model) * model.noise[:, None, None]
    scaled = np.sqrt(at.weight)[:, None] / sigma
    residual = at.residual * np.sqrt(at.weight)[:, None] / model.noise[:, None, None]
    matrix, slope = np.eye(unknowns.size), unknowns.copy()
    deviations, change = model.linear_deviations, []
    for receiver in range(model.n_receivers):
        weight = scaled[receiver].ravel()[:, None]
        rows = weight * columns[receiver].reshape(weight.size, -1)
        basis = weight * at.basis[receiver].reshape(weight.size, -1)
        mixed = basis.T @ rows
        inner = cho_factor(basis.T @ basis + np.diag(deviations[receiver] ** -2.0))
        solved = cho_solve(inner, mixed)
        matrix += rows.T @ rows - mixed.T @ solved
        slope -= rows.T @ residual[receiver].ravel()
        change.append(-solved)
    off, rows = stated_floor(model, at.values, _inputs_at(model, at.values))
    return NormalEquations(matrix + rows.T @ rows, slope + rows.T @ off, np.array(change))


def slopes_of(model: DropModel, at: Evaluation) -> FloatArray:
    """Return the derivatives of the channels, coefficients held, (n_receivers, 2, n_bins, n_unknowns)."""
    values, layout = at.values, model.layout
    inputs = _inputs_at(model, values)
    gain = wave_gain(model, at)
    waves = at.waves if not model.linear.free_ways else replace(at.waves, strength=at.waves.scattered)
    scaled = replace(waves, path=waves.path * gain, mean=waves.mean * gain[..., 0, :])
    own = receiver_slopes(at.node_m, values.theta, layout, inputs, EVERY, at.excess, scaled)
    stated = setup_slopes(at.node_m, scaled, values.theta, layout, inputs)
    n_receivers, n_bins = model.n_receivers, model.bins.n_bins
    out = np.zeros((n_receivers, 2, n_bins, model.stated.stop + layout.size))
    _, by_flights = Flights.of(values.flights).position_and_slopes(model.bins.time_s)
    for axis in range(3):
        out[..., model.flights] += own.by_position[:, :, axis, :, None] * by_flights[:, axis].T
    first = model.stated.start
    out[..., first : first + 3] = np.moveaxis(stated.by_antennas[:, 0], 1, -1)
    for receiver, by_place in enumerate(model.setup.receiver_slopes(values.setup)):
        part = slice(first + 3 + 3 * receiver, first + 6 + 3 * receiver)
        out[receiver, ..., part] = np.moveaxis(stated.by_antennas[receiver, 1], 0, -1) @ by_place
    out[..., model.stated.stop - 1] = -inputs.wavenumber * stated.by_wavenumber
    theta = out[..., model.stated.stop :]
    theta[..., layout.shared] = own.by_shared
    for receiver, places in enumerate(layout.receivers):
        theta[receiver, ..., places.without_drift] = own.by_own[receiver]
    return model.by_unknowns(out)


def with_last_flight(
    model: DropModel, unknowns: FloatArray, coefficients: FloatArray, steps: int = 6
) -> tuple[FloatArray, Evaluation]:
    """Return the unknowns with the last flight alone fitted, all else held, and the evaluation."""
    layout = Flights.of(model.mean.flights).layout
    places = np.zeros(model.free.size, dtype=np.bool_)
    places[layout.velocity(layout.n_flights - 1)] = places[layout.size - 1] = True
    own = len(model.setup.directions) + np.flatnonzero(places[model.free])
    at = evaluate(model, unknowns, coefficients=coefficients)
    before, damping = robust_cost(model, unknowns, at), 0.0
    for _ in range(steps):
        weight = np.sqrt(robust_weight(model, at.misfit))[:, None] / sigma_of(model)
        rows = (slopes_of(model, at)[..., own] * weight[..., None]).reshape(-1, own.size)
        slope = rows.T @ (at.residual * weight * sigma_of(model)).ravel()
        matrix, gained = rows.T @ rows + np.eye(own.size), 0.0
        while damping < 1e4:
            trial = unknowns.copy()
            trial[own] += np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), slope - unknowns[own])
            then = evaluate(model, trial, coefficients=coefficients)
            if (now := robust_cost(model, trial, then)) < before:
                unknowns, at, gained, before = trial, then, before - now, now
                damping = damping / 10.0 if damping > 1e-3 else 0.0
                break
            damping = max(10.0 * damping, 1e-2)
        if gained < 0.1:
            break
    return unknowns, at


_SCATTERED = (1e-3, 0.1), (1e-3, 0.3)
"""Least and most deviation of what else reflects and of an uneven floor: the first switches it off; a tenth of the echo
is a lot, and a third of what comes over the floor."""


def with_scattered(model: DropModel, at: Evaluation) -> DropModel:
    """Return the model with its deviations in `scattered` re-estimated for each receiver (MacKay 1992)."""
    group, deviations, out = model.linear.group, model.linear_deviations, model.scattered.copy()
    sigma = sigma_of(model) * model.noise[:, None, None]
    scaled = np.sqrt(at.weight)[:, None] / sigma
    for receiver, own in enumerate(at.coefficients):
        basis = (scaled[receiver][..., None] * at.basis[receiver]).reshape(-1, own.size)
        variance = np.diag(np.linalg.inv(basis.T @ basis + np.diag(deviations[receiver] ** -2.0)))
        determined = 1.0 - variance / deviations[receiver] ** 2
        for number, (least, most) in enumerate(_SCATTERED):
            which = group == number + 1
            size = np.sqrt((own[which] ** 2).sum() / max(float(determined[which].sum()), 1.0))
            out[receiver, number] = np.clip(size, least, most)
    return replace(model, scattered=out)


def minimise(
    model: DropModel,
    unknowns: FloatArray,
    *,
    rounds: int = 3,
    steps: int = 8,
    min_gain: float = 0.05,
    watch: Callable[[], None] | None = None,
) -> tuple[DropModel, FloatArray, Evaluation]:
    """Return model, unknowns and evaluation at the nearest minimum of the robust cost.

    Damped Gauss-Newton (Marquardt 1963); weights, ways and scattering are renewed in between.

    Parameters
    ----------
    model, unknowns
        Where to begin.
    rounds, steps
        How often what is held is renewed, and steps a round, at most.
    min_gain
        A round that gains less in cost is the last.
    watch
        Called before each step: what it raises ends the work.
    """
    damping = 0.0
    for number in range(rounds):
        model = model.renewed(model.values(unknowns))
        at = reweighted(model, evaluate(model, unknowns))
        begin = before = robust_cost(model, unknowns, at)
        for _ in range(steps):
            if watch is not None:
                watch()
            equations, tried = normal_equations(model, unknowns, at), None
            while damping < 1e6:
                damped = equations.matrix + damping * np.diag(np.diag(equations.matrix))
                step = -np.linalg.solve(damped, equations.slope)
                trial = evaluate(model, unknowns + step, at.weight)
                now = robust_cost(model, unknowns + step, trial)
                if now < before:
                    tried = step
                    break
                if -equations.slope @ step < min_gain:
                    break
                damping = max(10.0 * damping, 1e-3)
            if tried is None:
                break
            unknowns, gained = unknowns + tried, before - now
            at = reweighted(model, trial)
            before, damping = robust_cost(model, unknowns, at), damping / 10.0 if damping > 1e-4 else 0.0
            if gained < min_gain:
                break
        damping = min(damping, 1.0)
        if number and begin - before < min_gain:
            break
    return model, unknowns, at
