"""How what a receiver's bins should show changes with every unknown (derivatives of method 1, 4)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.mirrors import Detour, detour, turned
from radargui.estimation.forward.parameters import Layout, pair_of
from radargui.estimation.forward.signal_model import (
    FrontEndState,
    ModelInputs,
    amplitude_of,
    bias_of,
    complex_of,
    height_above_release,
    lobe_factor,
)
from radargui.estimation.forward.sphere import SphereFactors
from radargui.model.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, slots=True)
class ReceiverSlopes:
    """Derivatives of a receiver's two channels.

    Attributes
    ----------
    by_position
        Shape (2, 3, n_bins).
    by_own
        With respect to the receiver's own unknowns before those of its slow noise, shape (2, n_bins, n_own); the slow
        noise of a channel adds the inputs' functions to that channel alone.
    by_shared
        With respect to planes, the transmitter's reflections, their lobes, the transmitter's angle and crosstalk,
        shape (2, n_bins, n).
    """

    by_position: FloatArray
    by_own: FloatArray
    by_shared: FloatArray


def receiver_slopes(
    node_m: FloatArray,
    theta: FloatArray,
    layout: Layout,
    inputs: ModelInputs,
    receiver: int,
    excess: FloatArray | None = None,
) -> ReceiverSlopes:
    """Return the derivatives of `receiver_signal`; parameters as there.

    `excess` is what the channels before are more, shape (2, n_bins), the derivative with respect to crosstalk; what
    other channels do to these through it is neglected: parts in a hundred of each slope.
    """
    own = layout.receivers[receiver]
    k = inputs.wavenumber
    tx, rx = inputs.antennas.transmitter_m, inputs.antennas.receivers_m[receiver]
    from_tx, from_rx = node_m - tx[:, None, None, None], node_m - rx[:, None, None, None]
    r_tx, r_rx = (np.sqrt((away * away).sum(axis=0)) for away in (from_tx, from_rx))
    # the same path as in `receiver_signal`, whose derivative this is
    at_rest = np.linalg.norm(inputs.release_m - tx) + np.linalg.norm(inputs.release_m - rx)
    sphere = inputs.sphere_factors(theta, layout, receiver)
    amplitude = amplitude_of(theta, own, inputs, receiver, sphere)
    wave = amplitude * turned(k * (r_tx + r_rx - at_rest) + theta[own.phase])
    gradient = k * (from_tx / r_tx + from_rx / r_rx)
    mirrored = _mirrors(node_m, wave, theta, layout, inputs, receiver, sphere)
    z = _mean(mirrored.field)
    # d exp(j phi) = j exp(j phi) dphi; amplitude and maps change over decimetres and count as constant
    by_position = _mean(mirrored.slope + 1j * mirrored.field * gradient)
    bias = bias_of(theta, own, inputs)
    front_end = FrontEndState.of(theta, own)
    n_bins = inputs.range_factor.shape[1]
    by_own = np.zeros((2, n_bins, own.drift_i.start - own.first))

    def column(place: int) -> int:
        return place - own.first

    def columns(places: slice) -> slice:
        return slice(places.start - own.first, places.stop - own.first)

    # a phase turns direct and mirrored waves alike
    by_own[:, :, column(own.phase)] = front_end.channels(1j * z)
    by_own[:, :, column(own.log_amplitude)] = front_end.channels(z)
    by_own[0, :, column(own.offset.start)] = 1.0
    by_own[1, :, column(own.offset.start) + 1] = 1.0
    # g scales all of Q but its offset, the bias of the scene included
    q = front_end.channels(z + bias)[1]
    by_own[1, :, column(own.log_gain)] = q
    by_own[1, :, column(own.quadrature_error)] = front_end.q_by_quadrature_error((z + bias)[1])
    gain, error = front_end.gain_ratio, front_end.quadrature_error_rad
    by_own[0, :, columns(own.bias_i)] = inputs.bias
    # the quadrature error lets the real part of the bias into Q
    by_own[1, :, columns(own.bias_i)] = gain * np.sin(error) * inputs.bias
    by_own[1, :, columns(own.bias_q)] = gain * np.cos(error) * inputs.bias
    by_own[:, :, columns(own.amplitude_map)] = front_end.channels(z)[:, :, None] * inputs.amplitude_map
    for places, slopes in (
        (own.receiver_reflection, mirrored.by_receiver),
        (own.double_reflection, mirrored.by_double),
    ):
        by_own[:, :, columns(places)] = _complex_columns(front_end, slopes, n_bins)
    by_planes = [front_end.channels(_mean(slope)) for slope in mirrored.by_plane]
    by_transmitter = _complex_columns(front_end, mirrored.by_transmitter, n_bins)
    lobes = [_stack([front_end.channels(_mean(slope)) for slope in by], n_bins) for by in mirrored.by_lobes]
    by_own[:, :, columns(own.receiver_lobe)] = lobes[1]
    angles = [
        front_end.channels(z * by_direct + _mean(slope))
        for by_direct, slope in zip(sphere.direct_slopes, mirrored.by_angle, strict=True)
    ]
    by_own[:, :, columns(own.polarization)] = _stack(angles[1:], n_bins)
    by_crosstalk = np.zeros((2, n_bins, layout.sizes.crosstalk))
    if excess is not None and layout.sizes.crosstalk:
        by_crosstalk[:, :, 0] = excess
    by_shared = [_stack(by_planes, n_bins), by_transmitter, lobes[0], _stack(angles[:1], n_bins), by_crosstalk]
    return ReceiverSlopes(_front_vector(front_end, by_position), by_own, np.concatenate(by_shared, axis=2))


def _front_vector(front_end: FrontEndState, z: ComplexArray) -> FloatArray:
    """Apply the front end to (3, 2, n): returns (2, 3, n)."""
    return np.stack([front_end.channels(part) for part in z], axis=1)


def _mean(nodes: ComplexArray) -> ComplexArray:
    """Return the mean over the two nodes, the last axis but one."""
    return np.asarray(0.5 * (nodes[..., 0, :] + nodes[..., 1, :]))


def _complex_columns(front_end: FrontEndState, slopes: list[ComplexArray], n_bins: int) -> FloatArray:
    """Return derivatives with respect to real and imaginary parts of complex coefficients, (2, n, 2 n_coefficients)."""
    out = []
    for slope in slopes:
        z = _mean(slope)
        out += [front_end.channels(z), front_end.channels(1j * z)]
    return _stack(out, n_bins)


def _stack(columns: list[FloatArray], n_bins: int) -> FloatArray:
    return np.stack(columns, axis=2) if columns else np.zeros((2, n_bins, 0))


@dataclass(frozen=True, slots=True)
class _Mirrored:
    """The field at the nodes and what mirrors do to it; lists hold one entry a coefficient or a plane's unknown.

    `slope` is the derivative with respect to the position that the mirrors' detours add.
    """

    field: ComplexArray
    slope: ComplexArray | float
    by_plane: list[ComplexArray]
    by_transmitter: list[ComplexArray]
    by_receiver: list[ComplexArray]
    by_double: list[ComplexArray]
    by_lobes: tuple[list[ComplexArray], list[ComplexArray]]
    by_angle: list[ComplexArray]


def _mirrors(
    node_m: FloatArray,
    wave: ComplexArray,
    theta: FloatArray,
    layout: Layout,
    inputs: ModelInputs,
    receiver: int,
    sphere: SphereFactors,
) -> _Mirrored:
    if not inputs.planes:
        return _Mirrored(wave, 0.0, [], [], [], [], ([], []), [np.zeros_like(wave) for _ in sphere.direct_slopes])
    own = layout.receivers[receiver]
    unknown = layout.plane_unknowns(theta)
    t = complex_of(theta[layout.transmitter_reflection])
    r, x = complex_of(theta[own.receiver_reflection]), complex_of(theta[own.double_reflection])

    height = height_above_release(node_m, inputs)

    def detours(antenna: FloatArray, lobes: slice) -> list[Detour]:
        out = []
        for m, (plane, shift) in enumerate(zip(inputs.planes, unknown, strict=True)):
            one = detour(node_m, antenna, plane, shift, inputs.release_m, inputs.wavenumber)
            out.append(replace(one, ratio=one.ratio * lobe_factor(theta[pair_of(lobes, m)], height)))
        return out

    over_tx = detours(inputs.antennas.transmitter_m, layout.transmitter_lobe)
    over_rx = detours(inputs.antennas.receivers_m[receiver], own.receiver_lobe)
    scattered = sphere.mirrored
    # F is bilinear in what is sent and what is got: each derivative is the other factor
    sent = [t[m] * (wave * one.ratio) for m, one in enumerate(over_tx)]
    got = [r[n] * one.ratio for n, one in enumerate(over_rx)]
    field, by_double, by_transmitter, by_receiver = wave.copy(), [], [], []
    for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
        # a wave sent over m is received directly or over any mirror n
        after = scattered[1 + m, 0] + sum(one * scattered[1 + m, 1 + n] for n, one in enumerate(got))
        before = wave * scattered[0, 1 + m] + sum(one * scattered[1 + n, 1 + m] for n, one in enumerate(sent))
        by_transmitter.append(wave * a.ratio * after)
        by_receiver.append(before * b.ratio)
        by_double.append(wave * a.ratio * b.ratio * scattered[1 + m, 1 + m])
        field += sent[m] * after + got[m] * (wave * scattered[0, 1 + m]) + x[m] * by_double[m]
    slope, by_plane = np.zeros(node_m.shape, complex), []
    by_lobes: tuple[list[ComplexArray], list[ComplexArray]] = ([], [])
    for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
        # all that depends on the detour of an antenna over m: through ln rho the derivatives share it
        by_a = t[m] * by_transmitter[m] + x[m] * by_double[m]
        by_b = r[m] * by_receiver[m] + x[m] * by_double[m]
        slope += by_a * a.slope + by_b * b.slope
        by_plane += list(by_a * a.plane + by_b * b.plane)
        for by, one in zip(by_lobes, (by_a, by_b), strict=True):
            by += [one * height, one * height**2]
    by_angle = []
    for change in sphere.mirrored_slopes:
        total = np.zeros(wave.shape, complex)
        for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
            total += sent[m] * change[1 + m, 0] + got[m] * (wave * change[0, 1 + m])
            total += x[m] * change[1 + m, 1 + m] * (wave * a.ratio * b.ratio)
            total += sent[m] * sum(one * change[1 + m, 1 + n] for n, one in enumerate(got))
        by_angle.append(total)
    return _Mirrored(field, slope, by_plane, by_transmitter, by_receiver, by_double, by_lobes, by_angle)
