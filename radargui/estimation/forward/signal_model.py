"""What one receiver's bins should show: the equations of method 1 at the bins' nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.mirrors import MirrorPlane, detour_ratio, turned
from radargui.estimation.forward.parameters import Layout, ReceiverLayout, pair_of
from radargui.estimation.forward.sphere import SphereFactors, SphereFields, point_factors
from radargui.geometry.antennas import Antennas
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.front_end_equations import channels_of, q_by_quadrature_error

LOBE_LENGTH_M = 0.15  # height in which the lobes' parabolas count: about a motion's half, so that a and b are alike


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
        Of the amplitude at the bins, one at rest, shape (n_receivers, n_bins).
    drift
        Functions of slow noise at the bins, shape (n_bins, n_functions).
    sphere
        What it scatters along every path at the bins; None where it counts as a point.
    body
        Factors of each receiver in its place: a sphere of which the layout has no unknowns.
    """

    antennas: Antennas
    release_m: FloatArray
    wavenumber: float
    planes: tuple[MirrorPlane, ...]
    bias: FloatArray
    amplitude_map: FloatArray
    range_factor: FloatArray
    drift: FloatArray
    sphere: SphereFields | None = None
    body: tuple[SphereFactors, ...] | None = None

    def of_bins(self, part: slice) -> ModelInputs:
        """Return the inputs of some of the bins."""
        return replace(
            self,
            bias=self.bias[part],
            amplitude_map=self.amplitude_map[part],
            range_factor=self.range_factor[:, part],
            drift=self.drift[part],
            sphere=None if self.sphere is None else self.sphere.of_bins(part),
        )

    def sphere_factors(self, theta: FloatArray, layout: Layout, receiver: int) -> SphereFactors:
        """Return what the sphere multiplies the paths to a receiver with, the antennas turned as theta has them."""
        if self.body is not None:
            return self.body[receiver]
        if self.sphere is None:
            return point_factors(len(self.planes))
        angles = theta[layout.polarization.start], theta[layout.receivers[receiver].polarization.start]
        return self.sphere.factors(receiver, *(float(angle) for angle in angles))


@dataclass(frozen=True, slots=True)
class FrontEndState:
    """Gain ratio g and quadrature error eps of one receiver as theta has them."""

    gain_ratio: float
    quadrature_error_rad: float

    @classmethod
    def of(cls, theta: FloatArray, own: ReceiverLayout) -> FrontEndState:
        """Return them from the global parameters."""
        return cls(float(np.exp(theta[own.log_gain])), float(theta[own.quadrature_error]))

    def channels(self, z: ComplexArray) -> FloatArray:
        """Return what I and Q show of their Z, both shapes (2, n): each channel is sampled at its own time."""
        return channels_of(z[0], z[1], self.gain_ratio, self.quadrature_error_rad)

    def q_by_quadrature_error(self, z_of_q: ComplexArray) -> FloatArray:
        """Return dQ / d eps for the Z of Q."""
        return q_by_quadrature_error(z_of_q, self.gain_ratio, self.quadrature_error_rad)


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


def receiver_signal(
    node_m: FloatArray, theta: FloatArray, layout: Layout, inputs: ModelInputs, receiver: int
) -> ReceiverSignal:
    """Evaluate I = Re Z + c_I, Q = g (sin eps Re Z + cos eps Im Z) + c_Q as means over the bins' two nodes (method 1).

    Z = A exp(j phi) F + beta with phi = K (L - L at release) + phi_0, A from the range factor and a map, beta a map,
    F = 1 + sum T rho_tx M_m0 + sum R rho_rx M_0m + sum (T R + X) rho_tx rho_rx M_mn over the mirrors; the mirrored
    antennas look at the tracer with other parts of their lobes, so that ln |T| and ln |R| change with height (method 4,
    Mirrors). A sphere scatters into each path by its angles (M, and A by f / f at release); of a point M is one.

    Parameters
    ----------
    node_m
        Positions at the nodes, shape (3, 2 channels, 2 nodes, n_bins).
    theta
        Global parameters, shape (layout.size,).
    layout, inputs
        What theta means, and the rest.
    receiver
        Number.
    """
    own = layout.receivers[receiver]
    sphere = inputs.sphere_factors(theta, layout, receiver)
    direct = field_at_nodes(node_m, theta, layout, inputs, receiver, sphere)
    # the mean of a wave over a bin is that at its two nodes (Bins)
    z = (direct * _reflection_factor(node_m, theta, layout, inputs, receiver, sphere)).mean(axis=1)
    bias, front_end = bias_of(theta, own, inputs), FrontEndState.of(theta, own)
    # the mixer's own, behind the front end's gain: pick-up and 1/f noise do not turn with the tracer
    drift = np.stack([inputs.drift @ theta[own.drift_i], inputs.drift @ theta[own.drift_q]])
    besides = front_end.channels(np.stack([bias, bias])) + theta[own.offset][:, None] + drift
    return ReceiverSignal(front_end.channels(z) + besides, direct.mean(axis=(0, 1)), z.mean(axis=0), besides)


def field_at_nodes(
    node_m: FloatArray,
    theta: FloatArray,
    layout: Layout,
    inputs: ModelInputs,
    receiver: int,
    sphere: SphereFactors,
) -> ComplexArray:
    """Return A exp(j phi) without mirrors at the nodes, shape (2, 2, n_bins)."""
    own = layout.receivers[receiver]
    path = np.zeros(node_m.shape[1:])
    for antenna in (inputs.antennas.transmitter_m, inputs.antennas.receivers_m[receiver]):
        x, y, z = node_m - antenna[:, None, None, None]
        # against the release: phi_0 is then the phase there, whatever the antennas' places
        path += np.sqrt(x * x + y * y + z * z) - np.linalg.norm(inputs.release_m - antenna)
    phase = inputs.wavenumber * path + theta[own.phase]
    return np.asarray(amplitude_of(theta, own, inputs, receiver, sphere) * turned(phase))


def amplitude_of(
    theta: FloatArray, own: ReceiverLayout, inputs: ModelInputs, receiver: int, sphere: SphereFactors
) -> ComplexArray:
    """Return A from the range factor, the map and what the sphere scatters, shape (n_bins,)."""
    log_amplitude = theta[own.log_amplitude] + inputs.amplitude_map @ theta[own.amplitude_map]
    return np.asarray(sphere.direct * (inputs.range_factor[receiver] * np.exp(log_amplitude)))


def bias_of(theta: FloatArray, own: ReceiverLayout, inputs: ModelInputs) -> ComplexArray:
    """Return beta, shape (n_bins,)."""
    return np.asarray(inputs.bias @ theta[own.bias_i] + 1j * (inputs.bias @ theta[own.bias_q]))


def _reflection_factor(
    node_m: FloatArray,
    theta: FloatArray,
    layout: Layout,
    inputs: ModelInputs,
    receiver: int,
    sphere: SphereFactors,
) -> ComplexArray | float:
    """Return F, what the mirrors make of the direct field."""
    if not inputs.planes:
        return 1.0
    own = layout.receivers[receiver]
    t, r, x = (
        complex_of(theta[places])
        for places in (layout.transmitter_reflection, own.receiver_reflection, own.double_reflection)
    )
    antennas = inputs.antennas.transmitter_m, inputs.antennas.receivers_m[receiver]
    height, scattered = height_above_release(node_m, inputs), sphere.mirrored
    # one is the direct path
    out, sent, got = np.ones(node_m.shape[1:], complex), [], []
    for m, (plane, unknown) in enumerate(zip(inputs.planes, layout.plane_unknowns(theta), strict=True)):
        over_tx, over_rx = (
            detour_ratio(node_m, antenna, plane, unknown, inputs.release_m, inputs.wavenumber)
            * lobe_factor(theta[pair_of(lobes, m)], height)
            for antenna, lobes in zip(antennas, (layout.transmitter_lobe, own.receiver_lobe), strict=True)
        )
        sent.append(t[m] * over_tx)
        got.append(r[m] * over_rx)
        out += sent[m] * scattered[1 + m, 0] + got[m] * scattered[0, 1 + m]
        # a rough or small surface does not send both ways back alike: X takes what the product leaves
        out += x[m] * scattered[1 + m, 1 + m] * (over_tx * over_rx)
    # over a mirror on the way in and on the way out: phases add, amplitudes multiply (image theory, Balanis 4.7)
    for m, over_tx in enumerate(sent):
        for n, over_rx in enumerate(got):
            out += over_tx * over_rx * scattered[1 + m, 1 + n]
    return out


def height_above_release(node_m: FloatArray, inputs: ModelInputs) -> FloatArray:
    """Return (z - z at release) in units of 0.15 m at the nodes."""
    return np.asarray((node_m[2] - inputs.release_m[2]) / LOBE_LENGTH_M)


def lobe_factor(slope_and_bend: FloatArray, height: FloatArray) -> FloatArray:
    """Return exp(a h + b h^2), what a mirror's lobe does to its reflection, for one mirror's pair (a, b)."""
    slope, bend = slope_and_bend
    return np.asarray(np.exp((slope + bend * height) * height))


def complex_of(pairs: FloatArray) -> ComplexArray:
    """Return complex numbers from their real and imaginary parts by turns."""
    return np.asarray(pairs[0::2] + 1j * pairs[1::2])
