"""The joint problem: cost, slope and normal matrix of motion and mismatch together (method 4)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import bsr_matrix, csr_matrix, eye_array, kron

from radargui.estimation.forward.bins import Bins, Multiplexer
from radargui.estimation.forward.motion_spline import MotionSpline
from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.position_map import PositionBasis
from radargui.estimation.forward.signal_model import ModelInputs, ReceiverSignal, receiver_signal
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.forward.sphere import PolarisedSphere
from radargui.estimation.solve.normal import NormalMatrix
from radargui.estimation.solve.priors import Prior
from radargui.geometry.path_length import range_factor
from radargui.model.arrays import BoolArray, FloatArray, pieces
from radargui.model.errors import SolveError

# Beyond so many standard deviations a residual counts by its size, not its square: less than one in 10^4 of Gaussian
# ones. Impulses and what the model lacks then pull with a bounded force.
HUBER_SIGMAS = 4.0
_BINS_TOGETHER = 2048  # slopes of so many bins at a time: bounds the memory, changes nothing
_JITTERS = (0.0, 1e-13, 1e-11, 1e-9, 1e-7)  # of the diagonal: rounding of coefficients that hardly any bin sees


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
    jerk_sd
        Prior standard deviation of the third derivative in each span, m/s^3, shape (n_spans,).
    noise_scale
        Misfit as a factor on each receiver's noise, shape (n_receivers,).
    use
        Bins that count, shape (n_bins,).
    bias_basis, amplitude_basis
        Functions of position for bias and log amplitude.
    released_s
        From here on the release is over.
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
    jerk_sd: FloatArray
    noise_scale: FloatArray
    use: BoolArray
    bias_basis: PositionBasis
    amplitude_basis: PositionBasis
    released_s: float
    sphere: PolarisedSphere | None = None
    multiplexer: Multiplexer | None = None

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return len(self.layout.receivers)

    def at_places(self, place: FloatArray, theta: FloatArray) -> JointProblem:
        """Return the problem with maps, range factor and scattering evaluated at new places (3, n_bins).

        They change little over what a round moves the motion or a mirror: no derivative of theirs is needed.
        """
        antennas, release, planes = self.inputs.antennas, self.inputs.release_m, self.inputs.planes
        # images move with the planes: their scattering is taken where the last round left them
        unknown, body = self.layout.plane_unknowns(theta), self.sphere
        inputs = replace(
            self.inputs,
            sphere=None if body is None else body.fields(place, antennas, release, planes, unknown),
            bias=self.bias_basis(place),
            amplitude_map=self.amplitude_basis(place),
            range_factor=range_factor(place, antennas, release),
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
    spline, design, jerk
        The motion with the breaks in force, B at the bins, and its third derivative in the spans.
    excess
        Channel before minus channel, shape (n_channels, n_bins): slope of the crosstalk.
    """

    cost: float
    residual: FloatArray
    weight: FloatArray
    signals: tuple[ReceiverSignal, ...]
    node_m: FloatArray
    spline: MotionSpline
    design: csr_matrix
    jerk: csr_matrix
    excess: FloatArray


def linearise(problem: JointProblem, state: State) -> Linearised:
    """Evaluate model, residuals, weights and cost."""
    bins, theta = problem.bins, state.theta
    spline = problem.spline.with_breaks(theta[problem.layout.breaks])
    node = np.stack([bins.time_s - bins.node_s, bins.time_s + bins.node_s])
    # channels of equal delay share a spline's evaluation, the dearest part of a look
    delays, which = np.unique(problem.delay_s, return_inverse=True)
    offset = spline.offset((node + delays[:, None, None]).ravel(), state.coefficients)
    place = np.ascontiguousarray((offset + problem.inputs.release_m).T).reshape(3, delays.size, 2, bins.n_bins)
    node_m = np.take(place, which, axis=1)
    residual, weight = np.empty_like(bins.value), np.empty_like(bins.value)
    loss = 0.0
    signals = [
        receiver_signal(node_m[:, 2 * n : 2 * n + 2], theta, problem.layout, problem.inputs, n)
        for n in range(problem.n_receivers)
    ]
    # crosstalk mixes channels of different receivers: only when all signals are known
    excess = np.zeros_like(bins.value)
    if problem.multiplexer is not None and problem.layout.sizes.crosstalk:
        excess = problem.multiplexer.excess(np.concatenate([one.value for one in signals]), bins.time_s)
        kept = float(theta[problem.layout.crosstalk.start]) * excess.reshape(-1, 2, bins.n_bins)
        signals = [
            replace(one, value=one.value + own, besides=one.besides + own)
            for one, own in zip(signals, kept, strict=True)
        ]
    for receiver, signal in enumerate(signals):
        pair = slice(2 * receiver, 2 * receiver + 2)
        sigma = bins.sigma[pair] * problem.noise_scale[receiver]
        scaled = (signal.value - bins.value[pair]) / sigma
        size = np.abs(scaled)
        robust = np.minimum(1.0, HUBER_SIGMAS / np.maximum(size, HUBER_SIGMAS)) * problem.use
        # Huber's loss, and below the weights that make its slope those of least squares
        far = HUBER_SIGMAS * size - 0.5 * HUBER_SIGMAS**2
        loss += float((np.where(size < HUBER_SIGMAS, 0.5 * size**2, far) * problem.use).sum())
        residual[pair], weight[pair] = scaled, robust / sigma**2
    jerk, _, _ = spline.jerk()
    prior = problem.prior
    loss += 0.5 * float((((theta - prior.mean) / prior.sd) ** 2).sum())
    loss += 0.5 * float((((jerk @ state.coefficients) / problem.jerk_sd[:, None]) ** 2).sum())
    design = spline.design(bins.time_s)
    return Linearised(loss, residual, weight, tuple(signals), node_m, spline, design, jerk, excess)


@dataclass(frozen=True)
class Assembled:
    """Blocks of the normal matrix H = [[S, C], [C^T, M]] and the slope: motion S, global parameters M, coupling C."""

    s: csr_matrix
    c: FloatArray
    m: FloatArray
    slope_motion: FloatArray
    slope_global: FloatArray

    def factor(self, damping: float = 0.0) -> NormalMatrix:
        """Factor H with its diagonal raised by a share; the least share that makes it positive definite is added.

        Raises
        ------
        SolveError
            None does.
        """
        failed: SolveError | None = None
        # as little as will do: jitter is a prior that nobody chose
        for jitter in _JITTERS:
            share = damping + jitter
            s = csr_matrix(self.s + share * diagonal(self.s.diagonal())) if share else self.s
            m = self.m + share * np.diag(np.diag(self.m)) if share else self.m
            try:
                return NormalMatrix.factor(s, self.c, m)
            except SolveError as error:
                failed = error
        raise failed or SolveError("The normal matrix of the joint estimate cannot be factored.")


def assemble(problem: JointProblem, state: State, at: Linearised) -> Assembled:
    """Build H = J^T W J + priors and the slope J^T W r + priors, interleaving x, y, z in the motion."""
    layout, bins, n_bins = problem.layout, problem.bins, problem.bins.n_bins
    motion = kron(at.design, eye_array(3), format="csr")
    # a break acts through the motion alone: its columns are the motion's times dp/dtau
    breaks = at.spline.break_slopes(bins.time_s, state.coefficients)
    pull, curvature = np.zeros((n_bins, 3)), np.zeros((n_bins, 3, 3))
    c, m, slope = np.zeros((motion.shape[1], layout.size)), np.zeros((layout.size, layout.size)), np.zeros(layout.size)
    shared = np.arange(layout.shared.start, layout.shared.stop)
    for part in pieces(n_bins, _BINS_TOGETHER):
        rows, inputs = slice(3 * part.start, 3 * part.stop), problem.inputs.of_bins(part)
        near, near_motion = _touched(motion[rows])
        for receiver, (signal, own) in enumerate(zip(at.signals, layout.receivers, strict=True)):
            pair = slice(2 * receiver, 2 * receiver + 2)
            node_m, excess = at.node_m[:, pair, :, part], at.excess[pair, part]
            slopes = receiver_slopes(node_m, state.theta, layout, inputs, receiver, excess)
            weight, misfit = at.weight[pair, part], signal.value[:, part] - bins.value[pair, part]
            weighted = slopes.by_position * weight[:, None]
            pull[part] += (weighted * misfit[:, None]).sum(axis=0).T
            curvature[part] += np.einsum("pan,pbn->nab", weighted, slopes.by_position)
            # slow noise apart: its functions are many and touch one channel each
            places = np.concatenate([shared, np.arange(own.without_drift.start, own.without_drift.stop)])
            columns = np.concatenate([slopes.by_shared, slopes.by_own], axis=2)
            root = np.sqrt(weight).ravel()
            scaled = columns.reshape(root.size, -1) * root[:, None]
            m[np.ix_(places, places)] += scaled.T @ scaled
            slope[places] += scaled.T @ (root * misfit.ravel())
            block = _couple(weighted, columns)
            c[near, places] += near_motion.T @ block
            m[layout.breaks, places] += breaks[rows].T @ block
            if layout.sizes.drift == 0:
                continue
            for channel, drift in enumerate((own.drift_i, own.drift_q)):
                heavy = weight[channel][:, None] * inputs.drift
                m[drift, drift] += inputs.drift.T @ heavy
                m[places, drift] += columns[channel].T @ heavy
                m[drift, places] = m[places, drift].T
                slope[drift] += heavy.T @ misfit[channel]
                block = _outer(weighted[channel], inputs.drift)
                c[near, drift] += near_motion.T @ block
                m[layout.breaks, drift] += breaks[rows].T @ block
    # written once above; a symmetric matrix must be so to the last bit, or Cholesky takes the wrong half
    m[layout.breaks.stop :, layout.breaks] = m[layout.breaks, layout.breaks.stop :].T
    weight_matrix = bsr_matrix((curvature, np.arange(n_bins), np.arange(n_bins + 1)), shape=(3 * n_bins, 3 * n_bins))
    by_breaks = weight_matrix @ breaks
    c[:, layout.breaks] = (motion.T @ by_breaks).toarray()
    m[layout.breaks, layout.breaks] = (breaks.T @ by_breaks).toarray()
    slope[layout.breaks] = breaks.T @ pull.ravel()
    s = motion.T @ (weight_matrix @ motion)
    prior = problem.prior
    m[np.diag_indices(layout.size)] += 1.0 / prior.sd**2
    slope += (state.theta - prior.mean) / prior.sd**2
    # the jerk is a prior of each coordinate alike: gravity and drag are no jerk to speak of
    stiff = at.jerk.T @ diagonal(problem.jerk_sd**-2.0) @ at.jerk
    s = csr_matrix(s + kron(stiff, eye_array(3), format="csr"))
    slope_motion = motion.T @ pull.ravel() + (stiff @ state.coefficients).ravel()
    return Assembled(s, c, m, slope_motion, slope)


def diagonal(values: FloatArray) -> csr_matrix:
    """Return a sparse diagonal matrix."""
    n = values.size
    return csr_matrix((values, np.arange(n), np.arange(n + 1)), shape=(n, n))


def _touched(rows: csr_matrix) -> tuple[slice, csr_matrix]:
    """Return the range of columns that some rows of a band touch, and the rows with these columns alone."""
    first, last = (int(rows.indices.min()), int(rows.indices.max()) + 1) if rows.nnz else (0, 0)
    shape = rows.shape[0], last - first
    return slice(first, last), csr_matrix((rows.data, rows.indices - first, rows.indptr), shape=shape)


def _couple(weighted: FloatArray, columns: FloatArray) -> FloatArray:
    """Return sum over the two parts of (dm/dp)^T w J, x, y, z interleaved, shape (3 n_bins, n_columns)."""
    out = _outer(weighted[0], columns[0])
    out += _outer(weighted[1], columns[1])
    return out


def _outer(weighted: FloatArray, columns: FloatArray) -> FloatArray:
    """Return (dm/dp)^T w J of one part, x, y, z interleaved, shape (3 n_bins, n_columns)."""
    return np.asarray((weighted.T[:, :, None] * columns[:, None, :]).reshape(-1, columns.shape[1]))
