"""How what a receiver's bins should show changes with every unknown (derivatives of method 1, 4)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.lobes import Lobes
from radargui.estimation.forward.parameters import Layout, ReceiverLayout
from radargui.estimation.forward.signal_model import (
    FrontEndState,
    ModelInputs,
    Waves,
    bias_of,
    complex_of,
    reflections,
    shown,
    waves_at,
)
from radargui.model.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, slots=True)
class ReceiverSlopes:
    """Derivatives of a receiver's two channels.

    Attributes
    ----------
    at_nodes
        By the position at each node, the means' halves not yet taken, shape (3, 2 channels, 2 nodes, n_bins).
    columns
        With respect to what the receivers share (planes, the transmitter's reflections, their lobes, the transmitter's
        angle, crosstalk), then the receiver's own unknowns before those of its slow noise, shape (2, n_bins, n_shared +
        n_own); the slow noise of a channel adds the inputs' functions to that channel alone.
    n_shared
        How many are shared.
    """

    at_nodes: FloatArray
    columns: FloatArray
    n_shared: int

    @property
    def by_position(self) -> FloatArray:
        """By a position that both nodes share, shape (2, 3, n_bins)."""
        return np.moveaxis(_mean(self.at_nodes), 0, 1)

    @property
    def by_shared(self) -> FloatArray:
        """Columns of what the receivers share, shape (2, n_bins, n_shared)."""
        return self.columns[:, :, : self.n_shared]

    @property
    def by_own(self) -> FloatArray:
        """Columns of the receiver's own unknowns, shape (2, n_bins, n_own)."""
        return self.columns[:, :, self.n_shared :]


def receiver_slopes(
    node_m: FloatArray,
    theta: FloatArray,
    layout: Layout,
    inputs: ModelInputs,
    receiver: int,
    excess: FloatArray | None = None,
    waves: Waves | None = None,
) -> ReceiverSlopes:
    """Return the derivatives of `receiver_signal`; parameters as there.

    `excess` is what the channels before are more, shape (2, n_bins), the derivative with respect to crosstalk; what
    other channels do to these through it is neglected: parts in a hundred of each slope. `waves` are those at the
    nodes, where they are known already.
    """
    own, shared = layout.receivers[receiver], layout.shared
    waves = waves_at(node_m, theta, layout, inputs, receiver) if waves is None else waves
    turn = FrontEndState.of(theta, own).turn[:, None]
    n_bins, n_shared = inputs.range_factor.shape[1], shared.stop - shared.start
    out = np.zeros((2, n_bins, n_shared + own.drift_i.start - own.first))

    def place(unknown: int) -> int:
        return int(unknown - shared.start if unknown < shared.stop else unknown - own.first + n_shared)

    def put(places: slice, values: FloatArray) -> None:
        if places.stop > places.start:
            first = place(places.start)
            out[:, :, first : first + places.stop - places.start] = values

    # a phase turns direct and mirrored waves alike: d exp(j phi) = j exp(j phi) dphi
    z = shown(waves)
    out[:, :, place(own.phase)] = -z.imag
    out[:, :, place(own.log_amplitude)] = z.real
    out[0, :, place(own.offset.start)] = 1.0
    out[1, :, place(own.offset.start) + 1] = 1.0
    # g scales all of Q but its offset, the bias of the scene included
    q = (z + turn * bias_of(theta, own, inputs))[1]
    out[1, :, place(own.log_gain)] = q.real
    out[1, :, place(own.quadrature_error)] = -q.imag
    # the quadrature error lets the real part of the bias into Q
    put(own.bias_i, turn.real[:, :, None] * inputs.bias)
    put(own.bias_q, -turn.imag[:, :, None] * inputs.bias)
    put(own.amplitude_map, z.real[:, :, None] * inputs.amplitude_map)
    over = _over_points(waves)
    pull = _pull(waves, over, inputs.wavenumber)
    by_factors = waves.lobes.by_factors(over.real.reshape(*over.shape[:2], -1))
    for places, slopes in zip((layout.transmitter_lobe, own.receiver_lobe), by_factors, strict=True):
        put(places, np.moveaxis(_mean(slopes.reshape(-1, *node_m.shape[1:])), 0, 2))
    if inputs.planes:
        _put_mirrors(put, waves, theta, layout, own)
        planes = list(zip(inputs.planes, layout.plane_unknowns(theta), strict=True))
        antennas, axes = waves.antenna_m[:, 0], waves.lobes.axis[:, 0]
        moved = np.stack([plane.image_slope(antennas, unknown) for plane, unknown in planes], axis=1)
        turned = np.stack([plane.turned_slope(axes, unknown) for plane, unknown in planes], axis=1)
        by_planes = _by_planes(node_m, waves, waves.lobes, inputs, moved, turned, over[:, 1:], pull[:, 1:])
        put(layout.planes, np.moveaxis(by_planes, 0, 2))
    if layout.sizes.polarization and inputs.sphere is not None:
        angles = float(theta[layout.polarization.start]), float(theta[own.polarization.start])
        by_direct, by_mirrored = inputs.sphere.angle_slopes(receiver, *angles)
        reflected = reflections(theta, layout, own)[:, :, None, None] * waves.mean
        # the planes' own columns end with the walls': what the sphere scatters over them changes too
        by_walls = inputs.sphere.wall_slopes(receiver, *angles)
        for number, slope in enumerate(by_walls, start=place(layout.planes.stop) - len(by_walls)):
            out[:, :, number] += (slope[:, :, None] * reflected).sum(axis=(0, 1)).real
        for side, places in enumerate((layout.polarization, own.polarization)):
            changed = z * by_direct[side] + (by_mirrored[side, :, :, None] * reflected).sum(axis=(0, 1))
            put(places, changed.real[:, :, None])
    if excess is not None and layout.sizes.crosstalk:
        put(layout.crosstalk, excess[:, :, None])
    # amplitude and maps change over decimetres and count as constant
    at_nodes = node_m * pull.sum(axis=(0, 1)) - np.tensordot(waves.antenna_m, pull, axes=((0, 1), (0, 1)))
    return ReceiverSlopes(at_nodes, out, n_shared)


def ways_slopes(waves: Waves, by_ways: ComplexArray) -> FloatArray:
    """Return what the channels change by, (n, 2, n_bins), where the log of the ways (`log_ways`) changes so.

    `by_ways`: of transmitter and receiver, directly and over each mirror, shape (n, 2, 1 + n_mirrors, n_bins).
    """
    over = _over_points(waves)
    over = 0.5 * (over[..., 0, :] + over[..., 1, :])
    out = np.zeros((len(by_ways), *over.shape[2:]))
    for side, mirror in np.ndindex(over.shape[:2]):
        out += (over[side, mirror] * by_ways[:, side, mirror, None]).real
    return out


def _mean(nodes: FloatArray) -> FloatArray:
    """Return the mean over the two nodes, the last axis but one."""
    return np.asarray(0.5 * (nodes[..., 0, :] + nodes[..., 1, :]))


def _half(nodes: FloatArray) -> FloatArray:
    """Return half the difference of the two nodes, the last axis but one."""
    return np.asarray(0.5 * (nodes[..., 1, :] - nodes[..., 0, :]))


def _over_points(waves: Waves) -> ComplexArray:
    """Return what reaches the nodes from transmitter and images, and what goes to receiver and images.

    Shape (2, 1 + n_mirrors, 2, 2, n_bins).
    """
    if len(waves.path) == 1:
        return np.stack([waves.path[0], waves.path[0]])
    parts = waves.strength[:, :, None, None] * waves.path
    return np.stack([parts.sum(axis=1), parts.sum(axis=0)])


def _pull(waves: Waves, over: ComplexArray, wavenumber: float) -> FloatArray:
    """Return the slopes by the distance from each antenna and image, over that distance.

    A wave from a, w = share exp(jK |p - a|), has the slope (jK - 1 / r) w (p - a) / r; the direct wave's share is in
    the range factor, and so counts only as that against which the detours' shares stand. Shape (2, 1 + n_mirrors, 2, 2,
    n_bins).
    """
    length = waves.length_m
    pull = -wavenumber * over.imag
    if over.shape[1] > 1:
        pull[:, 1:] -= over.real[:, 1:] / length[:, 1:]
        pull[:, 0] += over.real[:, 1:].sum(axis=1) / length[:, 0]
    return np.asarray(pull / length)


def _put_mirrors(
    put: Callable[[slice, FloatArray], None],
    waves: Waves,
    theta: FloatArray,
    layout: Layout,
    own: ReceiverLayout,
) -> None:
    """Put the columns of T, R and X: F is bilinear in what is sent and what is got, each slope is the other factor."""
    scattered = waves.scattered[:, :, None] * waves.mean
    sent = np.append(1.0, complex_of(theta[layout.transmitter_reflection]))[:, None, None]
    got = np.append(1.0, complex_of(theta[own.receiver_reflection]))[:, None, None]
    put(layout.transmitter_reflection, _complex_columns((got * scattered[1:]).sum(axis=1)))
    put(own.receiver_reflection, _complex_columns((sent[:, None] * scattered[:, 1:]).sum(axis=0)))
    both = np.arange(1, len(scattered))
    put(own.double_reflection, _complex_columns(scattered[both, both]))


def _complex_columns(slopes: ComplexArray) -> FloatArray:
    """Return derivatives by real and imaginary parts by turns, (2, n_bins, 2 n), of slopes (n, 2, n_bins)."""
    pairs = np.stack([slopes.real, -slopes.imag], axis=1)
    return np.moveaxis(pairs.reshape(-1, *slopes.shape[1:]), 0, 2)


def _by_planes(
    node_m: FloatArray,
    waves: Waves,
    lobes: Lobes,
    inputs: ModelInputs,
    moved: FloatArray,
    turned: FloatArray,
    over: ComplexArray,
    pull: FloatArray,
) -> FloatArray:
    """Return the slopes by the planes' unknowns, shape (3 n_mirrors, 2, n_bins).

    Where a plane moves an image by da and turns its axis by du, a tracer at w from it moves against it, dr = -da.w / r,
    and is seen at another angle, dq = (da.u - du.w - (1 - q) da.w / r) / r.

    Parameters
    ----------
    node_m, waves, lobes, inputs
        See `receiver_slopes`.
    moved, turned
        da and du of each antenna, mirror and unknown, shape (2, n_mirrors, 3, 3).
    over, pull
        What comes from each image, and its slope by the distance over that distance, (2, n_mirrors, 2, 2, n_bins).
    """
    shape, image_m, length_m = over.shape, waves.antenna_m[:, 1:], waves.length_m[:, 1:]
    rest_m, q_rest = inputs.release_m - image_m, lobes.q_rest[:, 1:]
    rest_length = np.linalg.norm(rest_m, axis=2, keepdims=True)
    along, moved_rest, turned_rest = (
        (one @ way[..., None])[..., 0] for one, way in ((moved, lobes.axis[:, 1:]), (moved, rest_m), (turned, rest_m))
    )
    rest_angle = (along - turned_rest - (1.0 - q_rest) * moved_rest / rest_length) / rest_length
    # the phase counts from the release, from which an image moves away too
    rest_phase = inputs.wavenumber * moved_rest / rest_length
    by_angle, by_rest_angle = (over.real * one.reshape(shape) for one in lobes.by_angle())
    by_angle /= length_m
    moving = pull + by_angle * (1.0 - lobes.q[:, 1:].reshape(shape)) / length_m
    # summed over a bin's nodes first: what planes do to images is the same at all of them
    away_m, half_m = _mean(node_m) - image_m[..., None, None], _half(node_m)
    terms = np.empty((*shape[:2], 9, shape[2], shape[4]))
    for first, weight in ((0, moving), (3, by_angle)):
        terms[:, :, first : first + 3] = _mean(weight)[:, :, None] * away_m + _half(weight)[:, :, None] * half_m
    for place, weight in ((6, by_angle), (7, over.imag), (8, by_rest_angle)):
        terms[:, :, place] = _mean(weight)
    factors = np.concatenate([moved, turned, np.stack([-along, rest_phase, rest_angle], axis=3)], axis=3)
    slopes = (factors @ terms.reshape(*shape[:2], 9, -1)).sum(axis=0)
    return np.asarray(-slopes.reshape(-1, shape[2], shape[4]))
