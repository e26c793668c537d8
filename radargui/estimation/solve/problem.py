"""The joint problem: fixed data, unknowns, and the cost at a state."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from radargui.estimation.forward.bins import Bins, Multiplexer
from radargui.estimation.forward.equation_of_motion import EquationDeviation, EquationRows
from radargui.estimation.forward.motion_spline import MotionSpline, SplineSeries
from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.position_map import PositionBasis
from radargui.estimation.forward.signal_model import (
    EVERY,
    ModelInputs,
    ReceiverSignal,
    Waves,
    nodes_of,
    signal_of,
    waves_at,
)
from radargui.estimation.forward.sphere import PolarisedSphere
from radargui.estimation.forward.stated_floor import stated_term
from radargui.estimation.solve.priors import Prior
from radargui.model.arrays import BoolArray, FloatArray, pieces
from radargui.model.gravity import UNKNOWN_DRAG, Drag

# Beyond so many standard deviations a residual counts by its size, not its square: less than one in 10^4 of Gaussian
# ones. Impulses and what the model lacks then pull with a bounded force.
HUBER_SIGMAS = 4.0
BINS_TOGETHER = 2048  # slopes of so many bins at a time: bounds the memory, changes nothing


@dataclass(frozen=True)
class JointProblem:
    """Everything that stays fixed while the unknowns are improved.

    Attributes
    ----------
    bins, delay_s
        Data and the channels' delays.
    spline
        The motion with breaks at their first guess; theta holds the breaks in force.
    layout, inputs, prior
        Meaning, geometry and prior of the global parameters.
    in_flight
        Spans in which the motion obeys the equation of free flight, shape (n_spans,).
    equation_sd
        Prior standard deviation of each row of the motion's equation (`EquationRows`), m/s^3 or m/s^2, shape (n_rows,).
    noise_scale
        Misfit as a factor on each receiver's noise, shape (n_receivers,).
    use
        Bins that count, shape (n_bins,).
    bias_basis, amplitude_basis
        Functions of position for bias and log amplitude.
    released_s
        From here on the release is over.
    gravity_m_s2
        g of the place, for what asks whether something falls, and when it lands.
    slow_m_s
        v1 of the air's drag, where something flies.
    sphere
        The tracer and the antennas' polarisation; None where it counts as a point.
    multiplexer
        What the channels may have of each other.
    """

    bins: Bins
    delay_s: FloatArray
    spline: MotionSpline
    layout: Layout
    inputs: ModelInputs
    prior: Prior
    in_flight: BoolArray
    equation_sd: FloatArray
    noise_scale: FloatArray
    use: BoolArray
    bias_basis: PositionBasis
    amplitude_basis: PositionBasis
    released_s: float
    gravity_m_s2: float
    slow_m_s: float = 0.0
    sphere: PolarisedSphere | None = None
    multiplexer: Multiplexer | None = None

    @property
    def drag(self) -> Drag:
        """The air's drag as the flights are told of it."""
        if not self.layout.sizes.flight:
            return UNKNOWN_DRAG
        k = self.layout.flight.stop - 1
        return Drag(float(self.prior.mean[k]), float(self.prior.sd[k]), self.slow_m_s, 0.0)

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return len(self.layout.receivers)

    def placed(self, theta: FloatArray) -> JointProblem:
        """Return the problem with antennas, release and wave where theta, (n_global,), has them."""
        return replace(self, inputs=self.inputs.placed(theta[self.layout.setup])) if self.layout.sizes.setup else self

    def at_places(self, place: FloatArray, theta: FloatArray) -> JointProblem:
        """Return the problem with maps, range factor and scattering evaluated at new places (3, n_bins).

        They change little over what a round moves the motion or a mirror: no derivative of theirs is needed.
        """
        placed = self.inputs.placed(theta[self.layout.setup])
        antennas, release, planes = placed.antennas, placed.release_m, placed.planes
        # images move with the planes: their scattering is taken where the last round left them
        mirrors, body = theta[self.layout.mirrors], self.sphere
        inputs = replace(
            placed,
            sphere=None if body is None else body.fields(place, antennas, release, planes, mirrors),
            bias=self.bias_basis(place),
            amplitude_map=self.amplitude_basis(place),
            range_factor=placed.on_the_way(place, antennas, release),
        )
        return replace(self, inputs=inputs)


@dataclass(frozen=True)
class State:
    """The unknowns: spline coefficients (n, 3) relative to the release position, and the global parameters theta."""

    coefficients: FloatArray
    theta: FloatArray


@dataclass(frozen=True)
class Start:
    """A joint problem and the state from which it is improved."""

    problem: JointProblem
    state: State


@dataclass(frozen=True)
class Linearised:
    """The problem at a state.

    Attributes
    ----------
    cost
        Half the robust sum of squares plus half the priors' squares.
    residual
        Model minus data in standard deviations, shape (n_channels, n_bins).
    weight
        Robust weights over variance, same shape; zero where a bin does not count.
    signals
        Model of each receiver.
    node_m
        Positions at the bins' nodes at each channel's time, shape (3, n_channels, 2, n_bins).
    spline, series, motion
        The motion with the breaks in force, B with its derivatives at the bins, and what the motion is there
        (`SplineSeries.motion`).
    equation
        What it deviates from its equation.
    excess
        Channel before minus channel, shape (n_channels, n_bins): slope of the crosstalk.
    waves
        Of every receiver, for the slopes at this state; None where they were not kept.
    """

    cost: float
    residual: FloatArray
    weight: FloatArray
    signals: tuple[ReceiverSignal, ...]
    node_m: FloatArray
    spline: MotionSpline
    series: SplineSeries
    motion: FloatArray
    equation: EquationDeviation
    excess: FloatArray
    waves: Waves | None = None

    @property
    def design(self) -> csr_matrix:
        """B at the bins as a matrix."""
        return self.series.rows().matrix


def linearise(problem: JointProblem, state: State) -> Linearised:
    """Evaluate model, residuals, weights and cost."""
    problem = problem.placed(state.theta)
    bins, theta, layout = problem.bins, state.theta, problem.layout
    spline = problem.spline.with_breaks(theta[layout.breaks])
    series = spline.series(bins.time_s)
    motion = series.motion(state.coefficients)
    node_m = _nodes(problem, state, spline, series, motion)
    signals, excess, waves = signals_in_parts(problem, theta, node_m)
    sigma = bins.sigma * np.repeat(problem.noise_scale, 2)[:, None]
    residual = (np.concatenate([one.value for one in signals]) - bins.value) / sigma
    losses, weight = huber(residual)
    loss, weight = float((losses @ problem.use).sum()), weight * problem.use / sigma**2
    rows, n_breaks = EquationRows.of(spline, problem.in_flight), spline.break_s.size
    equation = EquationDeviation.of(rows, state.coefficients, theta[layout.flight], problem.slow_m_s, n_breaks)
    loss += 0.5 * float((((theta - problem.prior.mean) / problem.prior.sd) ** 2).sum())
    loss += 0.5 * float(((equation.value / problem.equation_sd[:, None]) ** 2).sum())
    stated = stated_term(theta, layout, problem.inputs)
    loss += 0.0 if stated is None else stated.cost
    return Linearised(loss, residual, weight, signals, node_m, spline, series, motion, equation, excess, waves)


def huber(residual: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Huber's loss of residuals in standard deviations, and the weights that make its slope that of squares."""
    size = np.abs(residual)
    near = np.minimum(size, HUBER_SIGMAS)
    return near * (size - 0.5 * near), HUBER_SIGMAS / np.maximum(size, HUBER_SIGMAS)


def signals_in_parts(
    problem: JointProblem, theta: FloatArray, node_m: FloatArray
) -> tuple[tuple[ReceiverSignal, ...], FloatArray, Waves | None]:
    """Return `signals_at`, so many bins at a time as the processor's cache holds; the waves of more are not kept."""
    if problem.bins.n_bins <= BINS_TOGETHER:
        return signals_at(problem, theta, node_m)
    layout, found = problem.layout, []
    for part in pieces(problem.bins.n_bins, BINS_TOGETHER):
        inputs = problem.inputs.of_bins(part)
        waves = waves_at(nodes_of(node_m[..., part]), theta, layout, inputs, EVERY)
        found.append(signal_of(waves, theta, layout, inputs, EVERY))
    return *_with_crosstalk(problem, theta, ReceiverSignal.joined(found)), None


def signals_at(
    problem: JointProblem, theta: FloatArray, node_m: FloatArray
) -> tuple[tuple[ReceiverSignal, ...], FloatArray, Waves]:
    """Return signals, excess and waves (`Linearised`) at positions of the nodes, (3, n_channels, 2, n_bins)."""
    waves = waves_at(nodes_of(node_m), theta, problem.layout, problem.inputs, EVERY)
    signal = signal_of(waves, theta, problem.layout, problem.inputs, EVERY)
    return *_with_crosstalk(problem, theta, signal), waves


def _with_crosstalk(
    problem: JointProblem, theta: FloatArray, signal: ReceiverSignal
) -> tuple[tuple[ReceiverSignal, ...], FloatArray]:
    """Return the signals of every receiver with what channels keep of each other, and the excess."""
    layout, signals = problem.layout, signal.each()
    # channels of different receivers mix: only when all signals are known
    excess = np.zeros_like(problem.bins.value)
    if problem.multiplexer is not None and layout.sizes.crosstalk:
        excess = problem.multiplexer.excess(np.concatenate([one.value for one in signals]), problem.bins.time_s)
        kept = float(theta[layout.crosstalk.start]) * excess.reshape(-1, 2, problem.bins.n_bins)
        signals = tuple(
            replace(one, value=one.value + own, besides=one.besides + own)
            for one, own in zip(signals, kept, strict=True)
        )
    return signals, excess


def node_offsets(problem: JointProblem) -> FloatArray:
    """Return how much later each channel's nodes are than the bins' mean times, shape (n_channels, 2, n_bins)."""
    node_s = problem.bins.node_s
    return np.asarray(problem.delay_s[:, None, None] + np.stack([-node_s, node_s]))


def _nodes(
    problem: JointProblem, state: State, spline: MotionSpline, series: SplineSeries, motion: FloatArray
) -> FloatArray:
    """Return positions at the bins' nodes at each channel's time, shape (3, n_channels, 2, n_bins)."""
    times, later = problem.bins.time_s, node_offsets(problem)
    place, velocity, acceleration, jerk = motion[:, :, None, None]
    # within its span the motion is its own series of Taylor
    node_m = later / 3.0 * jerk
    # in place: the arrays are the largest of a step
    for share, value in ((later / 2.0, acceleration), (later, velocity)):
        node_m += value
        node_m *= share
    node_m += place + problem.inputs.release_m[:, None, None, None]
    beyond = series.beyond(times + later)
    if beyond.any():
        offset = spline.offset((times + later)[beyond], state.coefficients)
        node_m[:, beyond] = (offset + problem.inputs.release_m).T
    return np.asarray(node_m)
