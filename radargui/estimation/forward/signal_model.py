"""What a receiver's bins should show, or those of all together: the equations of method 1 at the bins' nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.edges import Edges, edges_at
from radargui.estimation.forward.lobes import Lobes, lobes_at
from radargui.estimation.forward.parameters import N_LOBE, Layout, ReceiverLayout, polarisation_places
from radargui.estimation.forward.sphere import SphereFactors, SphereFields, point_factors
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.front_end import channel_factors, channels_of
from radargui.model.radar import Walls
from radargui.physics.mirrors import MirrorPlane, distances, turned
from radargui.physics.path_length import Antennas, range_factor
from radargui.physics.scattering import through_walls
from radargui.physics.setup_unknowns import SetupUnknowns


@dataclass(frozen=True, slots=True)
class ModelInputs:
    """What the signal model needs besides motion and global parameters.

    Attributes
    ----------
    antennas, release_m, wavenumber
        Geometry; wavenumber 2 pi / wavelength, 1/m.
    planes
        Mirrors.
    bias, amplitude_map
        Functions of the maps at the bins, shapes (n_bins, n_functions).
    range_factor
        Of the amplitude at the bins, one at rest, times what walls of a container do, shape (n_receivers, n_bins).
    drift
        Functions of slow noise at the bins, shape (n_bins, n_functions).
    sphere
        What it scatters along every path at the bins; None where it counts as a point.
    walls
        Of a container in the rays; None where none stands there.
    body
        Factors of each receiver in its place: a sphere of which the layout has no unknowns.
    setup, setup_at
        What the setup leaves open, and the values for which antennas, release and wavenumber stand here; None: zero.
    """

    antennas: Antennas
    release_m: FloatArray
    wavenumber: float
    planes: tuple[MirrorPlane, ...]
    bias: FloatArray
    amplitude_map: FloatArray
    range_factor: FloatArray | ComplexArray
    drift: FloatArray
    sphere: SphereFields | None = None
    walls: Walls | None = None
    body: tuple[SphereFactors, ...] | None = None
    setup: SetupUnknowns | None = None
    setup_at: FloatArray | None = None

    def placed(self, setup: FloatArray) -> ModelInputs:
        """Return the inputs with antennas, release and wave where the setup's unknowns, (n,), have them."""
        if self.setup is None or setup.size == 0:
            return self
        by = setup if self.setup_at is None else setup - self.setup_at
        return replace(
            self,
            antennas=self.setup.antennas(self.antennas, by),
            release_m=self.release_m + self.setup.by_release @ by,
            wavenumber=self.wavenumber * float(np.exp(self.setup.by_log_wavenumber @ by)),
            setup_at=setup,
        )

    def on_the_way(self, place: FloatArray, antennas: Antennas, release_m: FloatArray) -> FloatArray | ComplexArray:
        """Return `range_factor` at places (3, n)."""
        ranges = range_factor(place, antennas, release_m)
        if self.walls is None:
            return ranges
        return np.asarray(ranges * through_walls(place, antennas, self.walls, self.wavenumber))

    def of_bins(self, part: slice) -> ModelInputs:
        """Return the inputs of some of the bins."""
        return replace(
            self,
            bias=self.bias[part],
            amplitude_map=self.amplitude_map[part],
            range_factor=self.range_factor[:, part],
            drift=self.drift[:, part],
            sphere=None if self.sphere is None else self.sphere.of_bins(part),
            body=None if self.body is None else tuple(one.of_bins(part) for one in self.body),
        )

    def sphere_at(self, theta: FloatArray, layout: Layout, node_m: FloatArray) -> SphereFields | None:
        """Return what the sphere scatters with planes as theta has them and the sphere at nodes, see `waves_at`."""
        if self.sphere is None:
            return None
        return self.sphere.moved(theta[layout.mirrors], node_m.mean(axis=(-3, -2)))

    def sphere_factors(
        self, theta: FloatArray, layout: Layout, receiver: int | slice, sphere: SphereFields | None
    ) -> SphereFactors:
        """Return what a sphere multiplies the paths to a receiver with, the antennas turned as theta has them.

        Of several receivers, their number first.
        """
        if self.body is None and sphere is None:
            return point_factors(len(self.planes))
        numbers = range(len(layout.receivers))[receiver]
        if isinstance(numbers, int):
            return self._factors(theta, layout, numbers, sphere)
        each = [self._factors(theta, layout, n, sphere) for n in numbers]
        return SphereFactors(np.stack([one.direct for one in each]), np.stack([one.mirrored for one in each]))

    def _factors(self, theta: FloatArray, layout: Layout, receiver: int, sphere: SphereFields | None) -> SphereFactors:
        if self.body is not None:
            return self.body[receiver]
        if sphere is None:
            return point_factors(len(self.planes))
        sent, got = float(theta[layout.polarization.start]), float(theta[layout.receivers[receiver].polarization.start])
        return sphere.factors(receiver, sent, got)


@dataclass(frozen=True, slots=True)
class FrontEndState:
    """Gain ratio g and quadrature error eps of one receiver as theta has them."""

    gain_ratio: float
    quadrature_error_rad: float

    @classmethod
    def of(cls, theta: FloatArray, own: ReceiverLayout) -> FrontEndState:
        """Return them from the global parameters, shape (layout.size,)."""
        return cls(float(np.exp(theta[own.log_gain])), float(theta[own.quadrature_error]))

    def channels(self, z: ComplexArray) -> FloatArray:
        """Return what I and Q show of their Z, both shapes (2, n): each channel is sampled at its own time."""
        return channels_of(z[0], z[1], self.gain_ratio, self.quadrature_error_rad)


def turn_of(values: FloatArray, own: ReceiverLayout) -> ComplexArray:
    """Return h, see `channel_factors`, of a receiver's own unknowns (..., n_own) at their places, shape (..., 2)."""
    return channel_factors(np.exp(values[..., own.log_gain]), values[..., own.quadrature_error])


@dataclass(frozen=True, slots=True)
class Waves:
    """Waves that reach one receiver, over every way in (a) and out (b): 0 directly, m over mirror m.

    Of several receivers all shapes begin with their number.

    Attributes
    ----------
    antenna_m
        Transmitter and its images, receiver and its images, shape (2, 1 + n_mirrors, 3).
    length_m
        From these to the nodes, shape (2, 1 + n_mirrors, 2 channels, 2 nodes, n_bins).
    path
        h A exp(j phi) rho_a rho_b, whose real part the channels show, shape (1 + n_mirrors, 1 + n_mirrors, 2, 2,
        n_bins).
    mean
        Of the nodes, shape (1 + n_mirrors, 1 + n_mirrors, 2, n_bins).
    scattered, strength
        What the sphere scatters that way, and the same times the reflections of a and b, shape (1 + n_mirrors, 1 +
        n_mirrors, n_bins); n_bins may be 1 for a point.
    lobes
        What they show at the nodes.
    sphere
        What the sphere scatters to all receivers there; None of a point.
    edges
        Of the floor's plate; None of one that goes on.
    """

    antenna_m: FloatArray
    length_m: FloatArray
    path: ComplexArray
    mean: ComplexArray
    scattered: ComplexArray
    strength: ComplexArray
    lobes: Lobes
    sphere: SphereFields | None
    edges: Edges | None = None

    @property
    def n_ways(self) -> int:
        """1 + n_mirrors."""
        return int(self.mean.shape[-4])

    def of(self, receiver: int) -> Waves:
        """Return those of one receiver of several."""
        lobes = self.lobes
        own = Lobes(
            lobes.axis[receiver],
            lobes.q[receiver],
            lobes.q_rest[receiver],
            lobes.functions[receiver],
            lobes.direct[receiver],
            lobes.factors[receiver],
        )
        # of a point it is the same for all
        scattered = self.scattered if self.scattered.ndim < self.mean.ndim - 1 else self.scattered[receiver]
        strength = self.strength if self.strength.ndim < self.mean.ndim - 1 else self.strength[receiver]
        return Waves(
            self.antenna_m[receiver],
            self.length_m[receiver],
            self.path[receiver],
            self.mean[receiver],
            scattered,
            strength,
            own,
            self.sphere,
            None if self.edges is None else self.edges.of(receiver),
        )


@dataclass(frozen=True, slots=True)
class ReceiverSignal:
    """Model of a receiver's two channels.

    Attributes
    ----------
    value
        Shape (2, n_bins).
    direct, field
        A exp(j phi) without and with mirrors, averaged over channels and nodes, shape (n_bins,).
    besides
        Offsets, bias and drift as the channels show them, shape (2, n_bins).
    """

    value: FloatArray
    direct: ComplexArray
    field: ComplexArray
    besides: FloatArray

    @staticmethod
    def joined(parts: Sequence[ReceiverSignal]) -> ReceiverSignal:
        """Return those of some bins one after the other."""
        columns = zip(*((one.value, one.direct, one.field, one.besides) for one in parts), strict=True)
        value, direct, field, besides = (np.concatenate(own, axis=-1) for own in columns)
        return ReceiverSignal(value, direct, field, besides)

    def each(self) -> tuple[ReceiverSignal, ...]:
        """Return those of each of several receivers."""
        columns = (self.value, self.direct, self.field, self.besides)
        return tuple(ReceiverSignal(*own) for own in zip(*columns, strict=True))


_NOTHING = 1e-12  # of |Z|^2: an echo that is not there has no harmonics
EVERY = slice(None)
"""All receivers together: what is returned has their number first."""


def nodes_of(node_m: FloatArray) -> FloatArray:
    """Return positions at the nodes of all channels, (3, n_channels, 2, n), by receiver, (n_receivers, 3, 2, 2, n)."""
    return np.ascontiguousarray(node_m.reshape(3, -1, 2, *node_m.shape[2:]).swapaxes(0, 1))


def signal_of(
    waves: Waves, theta: FloatArray, layout: Layout, inputs: ModelInputs, receiver: int | slice
) -> ReceiverSignal:
    """Return I = Re Z + c_I, Q = g (sin eps Re Z + cos eps Im Z) + c_Q as means over the bins' two nodes (method 1).

    Z = E + h_- conj(E)^3 / |E|^2 + h_+ E^3 / |E|^2 + beta with the echo E = A exp(j phi) F, what a mixer's third
    harmonics make of it, phi = K (L - L at release) + phi_0, A from the range factor and a map, beta a map,
    F = 1 + sum T rho_tx M_m0 + sum R rho_rx M_0m + sum (T R + X) rho_tx rho_rx M_mn over the mirrors; the mirrored
    antennas look at the tracer with other parts of their lobes, so that ln |T| and ln |R| change with its place (method
    4, Mirrors). A sphere scatters into each path by its angles (M, and A by f / f at release); of a point M is one.

    Parameters
    ----------
    waves
        As `waves_at` gives them for the other parameters, which are the same.
    theta, layout, inputs, receiver
        As for `waves_at`.
    """
    own, values = layout.own, layout.own_values(theta, receiver)
    z = shown(waves)
    turn, bias = turn_of(values, own)[..., None], bias_of(values, own, inputs)
    # what the mixer makes of the echo besides is as little the echo as an offset is
    made = (harmonics_of(z, turn) * complex_of(values[..., own.harmonics])[..., None, None]).sum(axis=-3)
    besides = (turn * (bias[..., None, :] + made)).real + values[..., own.offset, None]
    if layout.sizes.drift:
        # the mixer's own, behind the front end's gain: pick-up and 1/f noise do not turn with the tracer
        functions = inputs.drift.reshape(-1, 2, *inputs.drift.shape[1:])[receiver]
        drift = values[..., own.drift_i.start : own.drift_q.stop].reshape(*values.shape[:-1], 2, -1, 1)
        besides += (functions @ drift)[..., 0]
    direct, field = ((one / turn).mean(axis=-2) for one in (waves.mean[..., 0, 0, :, :], z))
    return ReceiverSignal(z.real + besides, direct, field, besides)


def harmonics_of(shows: ComplexArray, turn: ComplexArray) -> ComplexArray:
    """Return waves as large as Z that turn at -3 and +3 times its phase, shape (..., 2 harmonics, 2, n_bins).

    What a mixer's third harmonics make of an echo: conj(Z)^3 / |Z|^2 and Z^3 / |Z|^2.

    Parameters
    ----------
    shows
        h Z as `shown` returns it, shape (..., 2, n_bins).
    turn
        h, shape (..., 2, 1).
    """
    z = shows / turn
    forwards = z**3 / np.maximum(z.real**2 + z.imag**2, _NOTHING)
    return np.stack([forwards.conj(), forwards], axis=-3)


def shown(waves: Waves) -> ComplexArray:
    """Return h Z without bias, the sum over all ways, shape (..., 2, n_bins)."""
    if waves.n_ways == 1:
        return waves.mean[..., 0, 0, :, :]
    # the mean of a wave over a bin is that at its two nodes (Bins)
    return np.asarray((waves.strength[..., None, :] * waves.mean).sum(axis=(-4, -3)))


def waves_at(
    node_m: FloatArray, theta: FloatArray, layout: Layout, inputs: ModelInputs, receiver: int | slice
) -> Waves:
    """Return the waves of all ways from the transmitter to a receiver, or to `EVERY` one.

    Parameters
    ----------
    node_m
        Positions at the nodes, shape (3, 2 channels, 2 nodes, n_bins); of every receiver as `nodes_of` gives them.
    theta
        Global parameters, shape (layout.size,).
    layout, inputs
        What theta means, and the rest.
    receiver
        Number.
    """
    own, values, k = layout.own, layout.own_values(theta, receiver), inputs.wavenumber
    shape = node_m.shape[:-4] + node_m.shape[-3:]
    antenna_m, length, change, lobes = _ways(node_m, theta, layout, inputs, receiver)
    moved = inputs.sphere_at(theta, layout, node_m)
    sphere = inputs.sphere_factors(theta, layout, receiver, moved)
    amplitude = turn_of(values, own)[..., None] * amplitude_of(values, own, inputs, receiver, sphere)[..., None, :]
    n_ways, lead = antenna_m.shape[-2], node_m.shape[:-4]
    path: ComplexArray = np.empty((*lead, n_ways, n_ways, *node_m.shape[-3:]), complex)
    phase = k * (change[..., 0, 0, :] + change[..., 1, 0, :]) + values[..., own.phase, None]
    # amplitude and phase change together over a bin: the range factor's mean would shift the phase's
    ways = (length[..., 0, 0, :] * length[..., 1, 0, :]).reshape(shape)
    direct = amplitude[..., None, :] * turned(phase).reshape(shape)
    direct *= ways.mean(axis=-2, keepdims=True) / ways
    np.multiply(direct, lobes.of_direct().reshape(shape), out=path[..., 0, 0, :, :, :])
    strength = sphere.mirrored
    fields = None if moved is None else moved.directions(theta[polarisation_places(layout)])[receiver]
    edges = edges_at(node_m, antenna_m[..., 0, :], theta, layout, inputs.planes, fields, k)
    if n_ways > 1:
        # the longer way arrives weaker; a lobe changes it with the place
        share = np.exp(lobes.exponents()) * length[..., :1, :] / length[..., 1:, :]
        detour = share * turned(k * (change[..., 1:, :] - change[..., :1, :]))
        detour = detour.reshape(*lead, 2, -1, *node_m.shape[-3:])
        if edges is not None:
            detour[..., 0, :, :, :] *= edges.value()[..., None, :, :]
        # over a mirror on the way in and on the way out: phases add, amplitudes multiply (image theory, Balanis 4.7)
        sent, got = detour[..., 0, :, :, :, :], detour[..., 1:, :, :, :, :]
        np.multiply(path[..., :1, 0, :, :, :], sent, out=path[..., 1:, 0, :, :, :])
        np.multiply(path[..., :, :1, :, :, :], got, out=path[..., :, 1:, :, :, :])
        strength = reflections(theta, layout, own, values)[..., None] * strength
    mean = 0.5 * (path[..., 0, :] + path[..., 1, :])
    length = length.reshape(*lead, 2, -1, *node_m.shape[-3:])
    return Waves(antenna_m, length, path, mean, sphere.mirrored, strength, lobes, moved, edges)


def _ways(
    node_m: FloatArray, theta: FloatArray, layout: Layout, inputs: ModelInputs, receiver: int | slice
) -> tuple[FloatArray, FloatArray, FloatArray, Lobes]:
    """Return antennas and images, lengths from there to the nodes, (2, 1 + n_mirrors, n), also against the release."""
    unknown, own, values = layout.plane_unknowns(theta), layout.own, layout.own_values(theta, receiver)
    receivers_m = inputs.antennas.receivers_m[receiver]
    ends = np.stack([np.broadcast_to(inputs.antennas.transmitter_m, receivers_m.shape), receivers_m], axis=-2)
    images = [plane.image(ends, one) for plane, one in zip(inputs.planes, unknown, strict=True)]
    antenna_m = np.stack([ends, *images], axis=-2)
    node = np.ascontiguousarray(node_m.reshape(*node_m.shape[:-3], -1))
    length = distances(node, antenna_m.reshape(*antenna_m.shape[:-3], -1, 3))
    length = length.reshape(*antenna_m.shape[:-1], node.shape[-1])
    # against the release: phi_0 is then the phase there, whatever the antennas' places, and no shift of a plane turns
    # T and R by radians
    change = length - np.linalg.norm(inputs.release_m - antenna_m, axis=-1)[..., None]
    of_own = values[..., own.receiver_lobe]
    both = np.stack([np.broadcast_to(theta[layout.transmitter_lobe], of_own.shape), of_own], axis=-2)
    factors = both.reshape(*both.shape[:-1], -1, N_LOBE)
    lobes = lobes_at(node, length, antenna_m, (inputs.planes, unknown), inputs.release_m, factors)
    return antenna_m, length, change, lobes


def log_ways(node_m: FloatArray, theta: FloatArray, layout: Layout, inputs: ModelInputs, receiver: int) -> ComplexArray:
    """Return the log of what each way in and out gives `Waves.path`, but for constants, (2, 1 + n_mirrors, n_nodes)."""
    _, length, change, lobes = _ways(node_m, theta, layout, inputs, receiver)
    out = 1j * inputs.wavenumber * change
    out[:, 1:] += lobes.exponents() + np.log(length[:, :1] / length[:, 1:])
    return np.asarray(out + lobes.factors[:, :1, 1:] @ lobes.direct)


def reflections(
    theta: FloatArray, layout: Layout, own: ReceiverLayout, values: FloatArray | None = None
) -> ComplexArray:
    """Return T_a R_b, T_0 = R_0 = 1, and X besides where both go over one mirror, (..., 1 + n_mirrors, 1 + n_mirrors).

    `values`: own unknowns (..., n_own) that `own` places; left out, theta, which `own` places too.
    """
    values = theta if values is None else values
    t = complex_of(theta[layout.transmitter_reflection])
    r, x = (complex_of(values[..., places]) for places in (own.receiver_reflection, own.double_reflection))
    out = np.ones((*r.shape[:-1], 1 + t.size, 1 + t.size), complex)
    out[..., 1:, :] *= t[:, None]
    out[..., 1:] *= r[..., None, :]
    # a rough or small surface does not send both ways back alike: X takes what the product leaves
    both = np.arange(1, 1 + t.size)
    out[..., both, both] += x
    return out


def amplitude_of(
    values: FloatArray, own: ReceiverLayout, inputs: ModelInputs, receiver: int | slice, sphere: SphereFactors
) -> ComplexArray:
    """Return A from the range factor, the map and what the sphere scatters, shape (..., n_bins)."""
    # a logarithm: an amplitude is positive, and lobes and distances multiply
    log_amplitude = values[..., own.log_amplitude, None] + values[..., own.amplitude_map] @ inputs.amplitude_map.T
    return np.asarray(sphere.direct * (inputs.range_factor[receiver] * np.exp(log_amplitude)))


def bias_of(values: FloatArray, own: ReceiverLayout, inputs: ModelInputs) -> ComplexArray:
    """Return beta of unknowns at their places, shape (..., n_bins)."""
    return np.asarray(values[..., own.bias_i] @ inputs.bias.T + 1j * (values[..., own.bias_q] @ inputs.bias.T))


def complex_of(pairs: FloatArray) -> ComplexArray:
    """Return complex numbers (..., n) from their real and imaginary parts by turns, (..., 2 n)."""
    return np.asarray(pairs[..., 0::2] + 1j * pairs[..., 1::2])
