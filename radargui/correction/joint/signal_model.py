"""What one receiver's bins should show."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.joint.layout import Layout, ReceiverLayout
from radargui.correction.joint.mirrors import ComplexArray, MirrorPlane, detour_ratio, turned
from radargui.geometry.antennas import Antennas
from radargui.model.arrays import FloatArray

_LOBE_LENGTH_M = 0.15


@dataclass(frozen=True, slots=True)
class Stage:
    """What the signal model needs besides the unknowns.

    Attributes
    ----------
    antennas, release_m, wavenumber
        Geometry; wavenumber 2 pi / wavelength.
    planes
        Mirrors.
    bias, level
        Map functions at the bins, shapes (n_bins, n_functions).
    law
        Range law of the amplitude at the bins, shape (n_receivers, n_bins).
    drift
        Functions of slow noise at the bins, shape (n_bins, n_functions).
    """

    antennas: Antennas
    release_m: FloatArray
    wavenumber: float
    planes: tuple[MirrorPlane, ...]
    bias: FloatArray
    level: FloatArray
    law: FloatArray
    drift: FloatArray

    def at(self, part: slice) -> Stage:
        """Return the stage of some of the bins."""
        return replace(
            self, bias=self.bias[part], level=self.level[part], law=self.law[:, part], drift=self.drift[part]
        )


@dataclass(frozen=True, slots=True)
class ReceiverSignal:
    """Model of a receiver's two channels.

    Attributes
    ----------
    value
        Shape (2, n_bins).
    direct, field
        A exp(j phi) without and with mirrors, averaged over parts and nodes, shape (n_bins,).
    besides
        Offsets, bias and drift as the channels show them, shape (2, n_bins).
    """

    value: FloatArray
    direct: ComplexArray
    field: ComplexArray
    besides: FloatArray


def receiver_signal(
    node_m: FloatArray, theta: FloatArray, layout: Layout, stage: Stage, receiver: int
) -> ReceiverSignal:
    """Evaluate I = Re Z + c_I, Q = g (sin eps Re Z + cos eps Im Z) + c_Q as means over the bins' two nodes.

    Z = A exp(j phi) F + beta with phi = K (L - L at release) + phi_0, A from the range law and a map, beta a map,
    F = (1 + sum T rho_tx) (1 + sum R rho_rx) + sum X rho_tx rho_rx over the mirrors; the mirrored antennas look at the
    tracer with other parts of their lobes, so that ln |T| and ln |R| change with height.

    Parameters
    ----------
    node_m
        Positions at the nodes, shape (3, 2 parts, 2 nodes, n_bins).
    theta
        Border vector.
    layout, stage
        What theta means, and the rest.
    receiver
        Number.
    """
    own = layout.receivers[receiver]
    direct = field_at_nodes(node_m, theta, layout, stage, receiver)
    z = (direct * _factor(node_m, theta, layout, stage, receiver)).mean(axis=1)
    bias, front = bias_of(theta, own, stage), FrontEnd(theta, own)
    noise = np.stack([stage.drift @ theta[own.drift_i], stage.drift @ theta[own.drift_q]])
    besides = front(np.stack([bias, bias])) + theta[own.offset][:, None] + noise
    return ReceiverSignal(front(z) + besides, direct.mean(axis=(0, 1)), z.mean(axis=0), besides)


def field_at_nodes(node_m: FloatArray, theta: FloatArray, layout: Layout, stage: Stage, receiver: int) -> ComplexArray:
    """Return A exp(j phi) without mirrors at the nodes, shape (2, 2, n_bins)."""
    own = layout.receivers[receiver]
    path = np.zeros(node_m.shape[1:])
    for antenna in (stage.antennas.transmitter_m, stage.antennas.receivers_m[receiver]):
        x, y, z = node_m - antenna[:, None, None, None]
        path += np.sqrt(x * x + y * y + z * z) - np.linalg.norm(stage.release_m - antenna)
    phase = stage.wavenumber * path + theta[own.phase]
    return np.asarray(amplitude_of(theta, own, stage, receiver) * turned(phase))


def amplitude_of(theta: FloatArray, own: ReceiverLayout, stage: Stage, receiver: int) -> FloatArray:
    """Return A from the range law and the map, shape (n_bins,)."""
    return np.asarray(stage.law[receiver] * np.exp(theta[own.log_amplitude] + stage.level @ theta[own.level]))


def bias_of(theta: FloatArray, own: ReceiverLayout, stage: Stage) -> ComplexArray:
    """Return beta, shape (n_bins,)."""
    return np.asarray(stage.bias @ theta[own.bias_i] + 1j * (stage.bias @ theta[own.bias_q]))


def _factor(node_m: FloatArray, theta: FloatArray, layout: Layout, stage: Stage, receiver: int) -> ComplexArray | float:
    """Return F, what the mirrors make of the direct field."""
    if not stage.planes:
        return 1.0
    own, unknown = layout.receivers[receiver], theta[layout.planes].reshape(-1, 3)
    t, r, x = (complex_of(theta[places]) for places in (layout.forward, own.backward, own.ghost))
    forward, backward = np.ones(node_m.shape[1:], complex), np.ones(node_m.shape[1:], complex)
    ghost = np.zeros(node_m.shape[1:], complex)
    antennas = stage.antennas.transmitter_m, stage.antennas.receivers_m[receiver]
    height = height_above_release(node_m, stage)
    for m, (plane, shift) in enumerate(zip(stage.planes, unknown, strict=True)):
        over_tx, over_rx = (
            detour_ratio(node_m, antenna, plane, shift, stage.release_m, stage.wavenumber)
            * lobe_factor(theta[places], m, height)
            for antenna, places in zip(antennas, (layout.forward_lobe, own.backward_lobe), strict=True)
        )
        forward += t[m] * over_tx
        backward += r[m] * over_rx
        ghost += x[m] * over_tx * over_rx
    return np.asarray(forward * backward + ghost)


def height_above_release(node_m: FloatArray, stage: Stage) -> FloatArray:
    """Return (z - z at release) in units of 0.15 m at the nodes."""
    return np.asarray((node_m[2] - stage.release_m[2]) / _LOBE_LENGTH_M)


def lobe_factor(lobe: FloatArray, mirror: int, height: FloatArray) -> FloatArray:
    """Return exp(a h + b h^2) for one mirror's pair (a, b)."""
    a, b = lobe[2 * mirror : 2 * mirror + 2]
    return np.asarray(np.exp((a + b * height) * height))


def complex_of(pairs: FloatArray) -> ComplexArray:
    """Return complex numbers from their real and imaginary parts by turns."""
    return np.asarray(pairs[0::2] + 1j * pairs[1::2])


class FrontEnd:
    """The receiver's front end: complex Z of each part (2, n) to the two channels (2, n)."""

    def __init__(self, theta: FloatArray, own: ReceiverLayout) -> None:
        self.gain = float(np.exp(theta[own.log_gain]))
        self.sine, self.cosine = float(np.sin(theta[own.skew])), float(np.cos(theta[own.skew]))

    def __call__(self, z: ComplexArray) -> FloatArray:
        """Return what the two channels show of each part's Z."""
        return np.stack([z[0].real, self.gain * (self.sine * z[1].real + self.cosine * z[1].imag)])

    def by_skew(self, z: ComplexArray) -> FloatArray:
        """Return dQ / d eps for the Q part's Z."""
        return np.asarray(self.gain * (self.cosine * z.real - self.sine * z.imag))
