"""How what a receiver's bins should show changes with every unknown."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.joint.layout import Layout
from radargui.correction.joint.mirrors import ComplexArray, Detour, detour, turned
from radargui.correction.joint.signal_model import (
    FrontEnd,
    Stage,
    amplitude_of,
    bias_of,
    complex_of,
    height_above_release,
    lobe_factor,
)
from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class ReceiverSlopes:
    """Derivatives of a receiver's two channels.

    Attributes
    ----------
    by_position
        Shape (2, 3, n_bins).
    by_own
        With respect to the receiver's own unknowns before those of its slow noise, shape (2, n_bins, n_own); the slow
        noise of a channel adds the stage's functions to that channel alone.
    by_mirrors
        With respect to planes, forward coefficients and their lobes, shape (2, n_bins, n).
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
    amplitude = amplitude_of(theta, own, stage, receiver)
    wave = amplitude * turned(k * (r_tx + r_rx - at_rest) + theta[own.phase])
    gradient = k * (from_tx / r_tx + from_rx / r_rx)
    mirrored = _mirrors(node_m, wave, theta, layout, stage, receiver)
    z = _mean(mirrored.field)
    by_position = _mean(mirrored.slope + 1j * mirrored.field * gradient)
    bias = bias_of(theta, own, stage)
    front = FrontEnd(theta, own)
    n_bins = stage.law.shape[1]
    by_own = np.zeros((2, n_bins, own.drift_i.start - own.first))

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
    for places, slopes in ((own.backward, mirrored.by_backward), (own.ghost, mirrored.by_ghost)):
        by_own[:, :, columns(places)] = _complex_columns(front, slopes, n_bins)
    by_planes = [front(_mean(slope)) for slope in mirrored.by_plane]
    by_forward = _complex_columns(front, mirrored.by_forward, n_bins)
    lobes = [_stack([front(_mean(slope)) for slope in by], n_bins) for by in mirrored.by_lobes]
    by_own[:, :, columns(own.backward_lobe)] = lobes[1]
    by_mirrors = np.concatenate([_stack(by_planes, n_bins), by_forward, lobes[0]], axis=2)
    return ReceiverSlopes(_front_vector(front, by_position), by_own, by_mirrors)


def _front_vector(front: FrontEnd, z: ComplexArray) -> FloatArray:
    """Apply the front end to (3, 2, n): returns (2, 3, n)."""
    return np.stack([front(part) for part in z], axis=1)


def _mean(nodes: ComplexArray) -> ComplexArray:
    """Return the mean over the two nodes, the last axis but one."""
    return np.asarray(0.5 * (nodes[..., 0, :] + nodes[..., 1, :]))


def _complex_columns(front: FrontEnd, slopes: list[ComplexArray], n_bins: int) -> FloatArray:
    """Return derivatives with respect to real and imaginary parts of complex coefficients, (2, n, 2 n_coefficients)."""
    out = []
    for slope in slopes:
        z = _mean(slope)
        out += [front(z), front(1j * z)]
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
    by_forward: list[ComplexArray]
    by_backward: list[ComplexArray]
    by_ghost: list[ComplexArray]
    by_lobes: tuple[list[ComplexArray], list[ComplexArray]]


def _mirrors(
    node_m: FloatArray, wave: ComplexArray, theta: FloatArray, layout: Layout, stage: Stage, receiver: int
) -> _Mirrored:
    if not stage.planes:
        return _Mirrored(wave, 0.0, [], [], [], [], ([], []))
    own = layout.receivers[receiver]
    unknown = theta[layout.planes].reshape(-1, 3)
    t = complex_of(theta[layout.forward])
    r, x = complex_of(theta[own.backward]), complex_of(theta[own.ghost])

    height = height_above_release(node_m, stage)

    def detours(antenna: FloatArray, lobe: FloatArray) -> list[Detour]:
        out = []
        for m, (plane, shift) in enumerate(zip(stage.planes, unknown, strict=True)):
            one = detour(node_m, antenna, plane, shift, stage.release_m, stage.wavenumber)
            out.append(replace(one, ratio=one.ratio * lobe_factor(lobe, m, height)))
        return out

    over_tx = detours(stage.antennas.transmitter_m, theta[layout.forward_lobe])
    over_rx = detours(stage.antennas.receivers_m[receiver], theta[own.backward_lobe])
    forward, backward, field = wave, np.ones(wave.shape, complex), np.zeros(wave.shape, complex)
    by_ghost = []
    for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
        forward = forward + t[m] * (wave * a.ratio)
        backward += r[m] * b.ratio
        by_ghost.append(wave * a.ratio * b.ratio)
        field += x[m] * by_ghost[m]
    field += forward * backward
    by_forward = [wave * backward * a.ratio for a in over_tx]
    by_backward = [forward * b.ratio for b in over_rx]
    slope, by_plane = np.zeros(node_m.shape, complex), []
    by_lobes: tuple[list[ComplexArray], list[ComplexArray]] = ([], [])
    for m, (a, b) in enumerate(zip(over_tx, over_rx, strict=True)):
        by_a = t[m] * by_forward[m] + x[m] * by_ghost[m]
        by_b = r[m] * by_backward[m] + x[m] * by_ghost[m]
        slope += by_a * a.slope + by_b * b.slope
        by_plane += list(by_a * a.plane + by_b * b.plane)
        for by, one in zip(by_lobes, (by_a, by_b), strict=True):
            by += [one * height, one * height**2]
    return _Mirrored(field, slope, by_plane, by_forward, by_backward, by_ghost, by_lobes)
