"""How what a receiver's bins should show changes with every unknown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.correction.joint.layout import Layout
from radargui.correction.joint.mirrors import ComplexArray, Detour, detour
from radargui.correction.joint.signal_model import FrontEnd, Stage, amplitude_of, bias_of, complex_of
from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class ReceiverSlopes:
    """Derivatives of a receiver's two channels.

    Attributes
    ----------
    by_position
        Shape (2, 3, n_bins).
    by_own
        With respect to the receiver's own unknowns, shape (2, n_bins, n_own).
    by_mirrors
        With respect to planes and forward coefficients, shape (2, n_bins, n_planes + n_forward).
    """

    by_position: FloatArray
    by_own: FloatArray
    by_mirrors: FloatArray


def receiver_slopes(
    node_m: FloatArray, theta: FloatArray, layout: Layout, stage: Stage, receiver: int
) -> ReceiverSlopes:
    """Return the derivatives of `receiver_signal`; parameters as there."""
    own = layout.receivers[receiver]
    k = stage.wavenumber
    tx, rx = stage.antennas.transmitter_m, stage.antennas.receivers_m[receiver]
    from_tx, from_rx = node_m - tx[:, None, None, None], node_m - rx[:, None, None, None]
    r_tx, r_rx = (np.sqrt((away * away).sum(axis=0)) for away in (from_tx, from_rx))
    at_rest = np.linalg.norm(stage.release_m - tx) + np.linalg.norm(stage.release_m - rx)
    wave = np.exp(1j * (k * (r_tx + r_rx - at_rest) + theta[own.phase]))
    gradient = 1j * k * (from_tx / r_tx + from_rx / r_rx)
    amplitude = amplitude_of(theta, own, stage, receiver)
    mirrored = _mirrors(node_m, theta, layout, stage, receiver)
    field = wave * mirrored.factor
    z = amplitude * field.mean(axis=1)
    by_position = amplitude * (field * gradient + wave * mirrored.slope).mean(axis=2)
    bias = bias_of(theta, own, stage)
    front = FrontEnd(theta, own)
    n_bins = stage.law.shape[1]
    by_own = np.zeros((2, n_bins, own.last - own.first))

    def column(place: int) -> int:
        return place - own.first

    def columns(places: slice) -> slice:
        return slice(places.start - own.first, places.stop - own.first)

    by_own[:, :, column(own.phase)] = front(1j * z)
    by_own[:, :, column(own.log_amplitude)] = front(z)
    by_own[0, :, column(own.offset.start)] = 1.0
    by_own[1, :, column(own.offset.start) + 1] = 1.0
    q = front(z + bias)[1]
    by_own[1, :, column(own.log_gain)] = q
    by_own[1, :, column(own.skew)] = front.by_skew((z + bias)[1])
    by_own[0, :, columns(own.bias_i)] = stage.bias
    by_own[1, :, columns(own.bias_i)] = front.gain * front.sine * stage.bias
    by_own[1, :, columns(own.bias_q)] = front.gain * front.cosine * stage.bias
    by_own[:, :, columns(own.level)] = front(z)[:, :, None] * stage.level
    by_own[0, :, columns(own.drift_i)] = stage.drift
    by_own[1, :, columns(own.drift_q)] = stage.drift
    for places, slopes in ((own.backward, mirrored.by_backward), (own.ghost, mirrored.by_ghost)):
        by_own[:, :, columns(places)] = _complex_columns(front, amplitude, wave, slopes)
    by_planes = [front(amplitude * (wave * slope).mean(axis=1)) for slope in mirrored.by_plane]
    by_forward = _complex_columns(front, amplitude, wave, mirrored.by_forward)
    by_mirrors = np.concatenate([_stack(by_planes, n_bins), by_forward], axis=2)
    return ReceiverSlopes(_front_vector(front, by_position), by_own, by_mirrors)


def _front_vector(front: FrontEnd, z: ComplexArray) -> FloatArray:
    """Apply the front end to (3, 2, n): returns (2, 3, n)."""
    return np.stack([front(part) for part in z], axis=1)


def _complex_columns(
    front: FrontEnd, amplitude: FloatArray, wave: ComplexArray, slopes: list[ComplexArray]
) -> FloatArray:
    """Return derivatives with respect to real and imaginary parts of complex coefficients, (2, n, 2 n_coefficients)."""
    out = []
    for slope in slopes:
        z = amplitude * (wave * slope).mean(axis=1)
        out += [front(z), front(1j * z)]
    return _stack(out, amplitude.size)


def _stack(columns: list[FloatArray], n_bins: int) -> FloatArray:
    return np.stack(columns, axis=2) if columns else np.zeros((2, n_bins, 0))


@dataclass(frozen=True, slots=True)
class _Mirrored:
    """F and its derivatives; lists hold one entry a coefficient or a plane's unknown."""

    factor: ComplexArray | float
    slope: ComplexArray | float
    by_plane: list[ComplexArray]
    by_forward: list[ComplexArray]
    by_backward: list[ComplexArray]
    by_ghost: list[ComplexArray]


def _mirrors(node_m: FloatArray, theta: FloatArray, layout: Layout, stage: Stage, receiver: int) -> _Mirrored:
    if not stage.planes:
        return _Mirrored(1.0, 0.0, [], [], [], [])
    own = layout.receivers[receiver]
    unknown = theta[layout.planes].reshape(-1, 3)
    t = complex_of(theta[layout.forward])
    r, x = complex_of(theta[own.backward]), complex_of(theta[own.ghost])

    def detours(antenna: FloatArray) -> list[Detour]:
        return [
            detour(node_m, antenna, plane, shift, stage.release_m, stage.wavenumber)
            for plane, shift in zip(stage.planes, unknown, strict=True)
        ]

    over_tx, over_rx = detours(stage.antennas.transmitter_m), detours(stage.antennas.receivers_m[receiver])
    forward, backward = np.ones(node_m.shape[1:], complex), np.ones(node_m.shape[1:], complex)
    forward_slope, backward_slope = np.zeros(node_m.shape, complex), np.zeros(node_m.shape, complex)
    ghost, ghost_slope = np.zeros(node_m.shape[1:], complex), np.zeros(node_m.shape, complex)
    for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
        forward += t[m] * a.ratio
        backward += r[m] * b.ratio
        forward_slope += t[m] * a.slope
        backward_slope += r[m] * b.slope
        ghost += x[m] * a.ratio * b.ratio
        ghost_slope += x[m] * (a.slope * b.ratio + a.ratio * b.slope)
    by_plane: list[ComplexArray] = []
    for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
        by_plane += list(
            t[m] * a.plane * backward + forward * r[m] * b.plane + x[m] * (a.plane * b.ratio + a.ratio * b.plane)
        )
    return _Mirrored(
        forward * backward + ghost,
        forward_slope * backward + forward * backward_slope + ghost_slope,
        by_plane,
        [a.ratio * backward for a in over_tx],
        [forward * b.ratio for b in over_rx],
        [a.ratio * b.ratio for a, b in zip(over_tx, over_rx, strict=True)],
    )
