"""How what a receiver's bins should show changes with every unknown (derivatives of method 1, 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.lobes import Lobes
from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.signal_model import (
    ModelInputs,
    Waves,
    bias_of,
    complex_of,
    harmonics_of,
    reflections,
    shown,
    turn_of,
    waves_at,
)
from radargui.estimation.forward.sphere import SphereFields
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.physics.setup_unknowns import SetupUnknowns


@dataclass(frozen=True, slots=True)
class ReceiverSlopes:
    """Derivatives of a receiver's two channels; of several receivers all shapes begin with their number.

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
        return _mean(self.at_nodes).swapaxes(-3, -2)

    @property
    def by_shared(self) -> FloatArray:
        """Columns of what the receivers share, shape (2, n_bins, n_shared)."""
        return self.columns[..., : self.n_shared]

    @property
    def by_own(self) -> FloatArray:
        """Columns of the receiver's own unknowns, shape (2, n_bins, n_own)."""
        return self.columns[..., self.n_shared :]


def receiver_slopes(
    node_m: FloatArray,
    theta: FloatArray,
    layout: Layout,
    inputs: ModelInputs,
    receiver: int | slice,
    excess: FloatArray | None = None,
    waves: Waves | None = None,
) -> ReceiverSlopes:
    """Return the derivatives of `signal_of`, or those of `EVERY` receiver; parameters as for `waves_at`.

    `excess` is what the channels before are more, shape (2, n_bins), the derivative with respect to crosstalk; what
    other channels do to these through it is neglected: parts in a hundred of each slope. `waves` are those at the
    nodes, where they are known already.
    """
    own, values, shared = layout.own, layout.own_values(theta, receiver), layout.shared
    waves = waves_at(node_m, theta, layout, inputs, receiver) if waves is None else waves
    turn = turn_of(values, own)
    n_bins, n_shared = inputs.range_factor.shape[1], shared.stop - shared.start
    out = np.zeros((*node_m.shape[:-4], 2, n_bins, n_shared + own.drift_i.start))

    def put(places: slice, slopes: FloatArray, after: int = n_shared) -> None:
        out[..., after + places.start : after + places.stop] = slopes

    def put_shared(places: slice, slopes: FloatArray) -> None:
        put(places, slopes, -shared.start)

    # a phase turns direct and mirrored waves alike: d exp(j phi) = j exp(j phi) dphi
    z = shown(waves)
    out[..., n_shared + own.phase] = -z.imag
    out[..., n_shared + own.log_amplitude] = z.real
    out[..., 0, :, n_shared + own.offset.start] = 1.0
    out[..., 1, :, n_shared + own.offset.start + 1] = 1.0
    # g scales all of Q but its offset, the bias of the scene included
    q = z[..., 1, :] + turn[..., 1, None] * bias_of(values, own, inputs)
    out[..., 1, :, n_shared + own.log_gain] = q.real
    out[..., 1, :, n_shared + own.quadrature_error] = -q.imag
    # the quadrature error lets the real part of the bias into Q
    put(own.bias_i, turn.real[..., None, None] * inputs.bias)
    put(own.bias_q, -turn.imag[..., None, None] * inputs.bias)
    # A stands in an exponential: dz / d ln A = z
    put(own.amplitude_map, z.real[..., None] * inputs.amplitude_map)
    # of a thousandth of the echo what moves it counts as constant
    put(own.harmonics, _complex_columns(turn[..., None, :, None] * harmonics_of(z, turn[..., None])))
    over = _over_points(waves)
    pull = _pull(waves, over, inputs.wavenumber)
    by_factors = _mean(
        waves.lobes.by_factors(over.real.reshape(*over.shape[:-3], -1)).reshape(*over.shape[:-4], -1, *over.shape[-3:])
    )
    put_shared(layout.transmitter_lobe, np.moveaxis(by_factors[..., 0, :, :, :], -3, -1))
    put(own.receiver_lobe, np.moveaxis(by_factors[..., 1, :, :, :], -3, -1))
    if inputs.planes:
        sent, got, both = _by_reflections(waves, theta, layout, values)
        put_shared(layout.transmitter_reflection, sent)
        put(own.receiver_reflection, got)
        put(own.double_reflection, both)
        planes = list(zip(inputs.planes, layout.plane_unknowns(theta), strict=True))
        antennas, axes = waves.antenna_m[..., 0, :], waves.lobes.axis[..., 0, :]
        moved = np.stack([plane.image_slope(antennas, unknown) for plane, unknown in planes], axis=-3)
        turned = np.stack([plane.turned_slope(axes, unknown) for plane, unknown in planes], axis=-3)
        of_images = over[..., 1:, :, :, :], pull[..., 1:, :, :, :]
        by_planes = _by_planes(node_m, waves, waves.lobes, inputs, moved, turned, *of_images)
        put_shared(layout.planes, np.moveaxis(by_planes, -3, -1))
    by_height = None
    sphere = waves.sphere
    if layout.sizes.polarization and sphere is not None:
        reflected = reflections(theta, layout, own, values)[..., None, None] * waves.mean
        by_direct, by_mirrored, by_mirrors = _by_angles(sphere, theta, layout, receiver)
        # what the sphere scatters over walls and exchanges with a floor changes too
        changes = (by_mirrors[..., None, :] * reflected[..., None, :, :, :, :]).sum(axis=(-4, -3)).real
        for number, place in enumerate(layout.planes.start - shared.start + sphere.which):
            out[..., place] += changes[..., number, :, :]
        if sphere.height is not None:
            by_height = sphere.height.normal[:, None, None, None] * changes[..., -1, :, :][..., None, :, None, :]
        changed = [
            z * by_direct[..., side, None, :] + (by_mirrored[..., side, :, :, None, :] * reflected).sum(axis=(-4, -3))
            for side in (0, 1)
        ]
        put_shared(layout.polarization, changed[0].real[..., None])
        put(own.polarization, changed[1].real[..., None])
    by_edge_of_place = None
    if waves.edges is not None:
        by_edges, by_plane, by_edge_of_place = (
            np.einsum("...scmn,...skmn->...kcmn", over[..., 1, :, :, :], one).real for one in waves.edges.slopes()
        )
        put_shared(layout.edges, np.moveaxis(_mean(by_edges), -3, -1))
        first = layout.planes.start - shared.start
        out[..., first : first + 3] += np.moveaxis(_mean(by_plane), -3, -1)
    if excess is not None and layout.sizes.crosstalk:
        put_shared(layout.crosstalk, excess[..., None])
    if layout.sizes.setup:
        stated = setup_slopes(node_m, waves, theta, layout, inputs)
        by_setup = _by_setup(stated, inputs.setup, receiver, inputs.wavenumber)
        put_shared(layout.setup, np.moveaxis(by_setup, -3, -1))
    # amplitude and maps change over decimetres and count as constant
    lead, points = node_m.shape[:-4], waves.antenna_m.reshape(*node_m.shape[:-4], -1, 3)
    toward = points.swapaxes(-1, -2) @ pull.reshape(*lead, points.shape[-2], -1)
    at_nodes = node_m * pull.sum(axis=(-5, -4))[..., None, :, :, :] - toward.reshape(node_m.shape)
    if by_height is not None:
        at_nodes += by_height
    if by_edge_of_place is not None:
        at_nodes += by_edge_of_place
    return ReceiverSlopes(at_nodes, out, n_shared)


@dataclass(frozen=True, slots=True)
class SetupSlopes:
    """Derivatives of a receiver's two channels by what the setup states; of several receivers their number first.

    Attributes
    ----------
    by_antennas
        By the places of transmitter and receiver, shape (2, 3, 2 channels, n_bins).
    by_release
        By the release, the motion going with it, shape (3, 2 channels, n_bins).
    by_wavenumber
        By K, shape (2 channels, n_bins).
    """

    by_antennas: FloatArray
    by_release: FloatArray
    by_wavenumber: FloatArray


def setup_slopes(
    node_m: FloatArray, waves: Waves, theta: FloatArray, layout: Layout, inputs: ModelInputs
) -> SetupSlopes:
    """Return how the channels change where an antenna stands elsewhere or the wave is longer; parameters as above.

    A wave from a has the phase K (|p - a| - |p0 - a|), p0 the release; with an antenna its images move. An antenna and
    the world, release and motion, that move against it are the same. Lobes and what the sphere scatters change over
    decimetres and count as constant.
    """
    over = _over_points(waves)
    pull = _pull(waves, over, inputs.wavenumber)
    from_release = waves.antenna_m - inputs.release_m
    rest_m = np.linalg.norm(from_release, axis=-1)
    turning = over.imag
    by_rest = inputs.wavenumber * _mean(turning)[..., None, :, :] * (from_release / rest_m[..., None])[..., None, None]
    weight = _mean(pull)[..., None, :, :]
    middle, half = _mean(node_m)[..., None, None, :, :, :], _half(node_m)[..., None, None, :, :, :]
    by_points = weight * (waves.antenna_m[..., None, None] - middle) - _half(pull)[..., None, :, :] * half + by_rest
    by_antennas = by_points[..., 0, :, :, :].copy()
    for number, (plane, unknown) in enumerate(zip(inputs.planes, layout.plane_unknowns(theta), strict=True), 1):
        # an image moves as the antenna does, mirrored
        over_mirror = np.moveaxis(by_points[..., number, :, :, :], -3, -1)
        by_antennas += np.moveaxis(plane.turned(over_mirror, unknown), -1, -3)
    change = waves.length_m - rest_m[..., None, None, None]
    by_wavenumber = -_mean(turning * change).sum(axis=(-4, -3))
    return SetupSlopes(by_antennas, -by_points.sum(axis=(-5, -4)), by_wavenumber)


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


def _by_setup(
    slopes: SetupSlopes, unknowns: SetupUnknowns | None, receiver: int | slice, wavenumber: float
) -> FloatArray:
    """Return the slopes by the setup's unknowns, shape (..., n, 2, n_bins), of those by places and wavenumber."""
    if unknowns is None:
        raise ValueError("theta has unknowns of a setup that the inputs do not know")
    receivers = unknowns.by_antenna[1:][receiver]
    ends = np.stack([np.broadcast_to(unknowns.by_antenna[0], receivers.shape), receivers], axis=-3)
    shape = slopes.by_antennas.shape
    flat = slopes.by_antennas.reshape(*shape[:-2], -1)
    by_place = (ends.swapaxes(-1, -2) @ flat).sum(axis=-3)
    by_place += unknowns.by_release.T @ slopes.by_release.reshape(*flat.shape[:-3], 3, -1)
    out = by_place.reshape(*shape[:-4], -1, *shape[-2:])
    return np.asarray(
        out + wavenumber * unknowns.by_log_wavenumber[:, None, None] * slopes.by_wavenumber[..., None, :, :]
    )


def _mean(nodes: FloatArray) -> FloatArray:
    """Return the mean over the two nodes, the last axis but one."""
    return np.asarray(0.5 * (nodes[..., 0, :] + nodes[..., 1, :]))


def _half(nodes: FloatArray) -> FloatArray:
    """Return half the difference of the two nodes, the last axis but one."""
    return np.asarray(0.5 * (nodes[..., 1, :] - nodes[..., 0, :]))


def _over_points(waves: Waves) -> ComplexArray:
    """Return what reaches the nodes from transmitter and images, and what goes to receiver and images.

    Shape (..., 2, 1 + n_mirrors, 2, 2, n_bins).
    """
    if waves.n_ways == 1:
        alone = waves.path[..., 0, :, :, :, :]
        return np.stack([alone, alone], axis=-5)
    parts = waves.strength[..., None, None, :] * waves.path
    return np.stack([parts.sum(axis=-4), parts.sum(axis=-5)], axis=-5)


def _pull(waves: Waves, over: ComplexArray, wavenumber: float) -> FloatArray:
    """Return the slopes by the distance from each antenna and image, over that distance.

    A wave from a, w = share exp(jK |p - a|), has the slope (jK - 1 / r) w (p - a) / r; the direct wave's share is in
    the range factor, and so counts only as that against which the detours' shares stand. Shape (..., 2, 1 + n_mirrors,
    2, 2, n_bins).
    """
    length = waves.length_m
    pull = -wavenumber * over.imag
    if waves.n_ways > 1:
        mirrored = over.real[..., 1:, :, :, :]
        pull[..., 1:, :, :, :] -= mirrored / length[..., 1:, :, :, :]
        pull[..., 0, :, :, :] += mirrored.sum(axis=-4) / length[..., 0, :, :, :]
    return np.asarray(pull / length)


def _by_reflections(
    waves: Waves, theta: FloatArray, layout: Layout, values: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the columns of T, R and X: F is bilinear in what is sent and got, each slope is the other factor."""
    own, scattered = layout.own, waves.scattered[..., None, :] * waves.mean
    sent = np.append(1.0, complex_of(theta[layout.transmitter_reflection]))
    got = complex_of(values[..., own.receiver_reflection])
    got = np.concatenate([np.ones((*got.shape[:-1], 1)), got], axis=-1)
    both = np.arange(1, waves.n_ways)
    return (
        _complex_columns((got[..., None, :, None, None] * scattered[..., 1:, :, :, :]).sum(axis=-3)),
        _complex_columns((sent[:, None, None, None] * scattered[..., :, 1:, :, :]).sum(axis=-4)),
        _complex_columns(scattered[..., both, both, :, :]),
    )


def _complex_columns(slopes: ComplexArray) -> FloatArray:
    """Return derivatives by real and imaginary parts by turns, (..., 2, n_bins, 2 n), of slopes (..., n, 2, n_bins)."""
    pairs = np.stack([slopes.real, -slopes.imag], axis=-3)
    return np.moveaxis(pairs.reshape(*slopes.shape[:-3], -1, *slopes.shape[-2:]), -3, -1)


def _by_angles(
    sphere: SphereFields, theta: FloatArray, layout: Layout, receiver: int | slice
) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return what the sphere's factors change by with the angles of transmitter and receiver, and with the planes.

    Shapes (..., 2, n_bins), (..., 2, 1 + n_mirrors, 1 + n_mirrors, n_bins) and (..., n, 1 + n_mirrors, 1 + n_mirrors,
    n_bins).
    """
    if isinstance(receiver, slice):
        each = [_by_angles(sphere, theta, layout, n) for n in range(len(layout.receivers))[receiver]]
        by_direct, by_mirrored, by_mirrors = (np.stack(own) for own in zip(*each, strict=True))
        return by_direct, by_mirrored, by_mirrors
    got = layout.receivers[receiver].polarization.start
    angles = float(theta[layout.polarization.start]), float(theta[got])
    return *sphere.angle_slopes(receiver, *angles), sphere.mirror_slopes(receiver, *angles)


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
    """Return the slopes by the planes' unknowns, shape (..., 3 n_mirrors, 2, n_bins).

    Where a plane moves an image by da and turns its axis by du, a tracer at w from it moves against it, dr = -da.w / r,
    and is seen at another angle, dq = (da.u - du.w - (1 - q) da.w / r) / r.

    Parameters
    ----------
    node_m, waves, lobes, inputs
        See `receiver_slopes`.
    moved, turned
        da and du of each antenna, mirror and unknown, shape (..., 2, n_mirrors, 3, 3).
    over, pull
        What comes from each image, and its slope by the distance over that distance, (..., 2, n_mirrors, 2, 2, n_bins).
    """
    shape, image_m, length_m = over.shape, waves.antenna_m[..., 1:, :], waves.length_m[..., 1:, :, :, :]
    rest_m, q_rest = inputs.release_m - image_m, lobes.q_rest[..., 1:, :]
    rest_length = np.linalg.norm(rest_m, axis=-1, keepdims=True)
    along, moved_rest, turned_rest = (
        (one @ way[..., None])[..., 0]
        for one, way in ((moved, lobes.axis[..., 1:, :]), (moved, rest_m), (turned, rest_m))
    )
    rest_angle = (along - turned_rest - (1.0 - q_rest) * moved_rest / rest_length) / rest_length
    # the phase counts from the release, from which an image moves away too
    rest_phase = inputs.wavenumber * moved_rest / rest_length
    by_angle, by_rest_angle = (over.real * one.reshape(shape) for one in lobes.by_angle())
    by_angle /= length_m
    moving = pull + by_angle * (1.0 - lobes.q[..., 1:, :].reshape(shape)) / length_m
    # summed over a bin's nodes first: what planes do to images is the same at all of them
    middle_m, half_m = (one(node_m)[..., None, None, :, :, :] for one in (_mean, _half))
    away_m = middle_m - image_m[..., None, None]
    terms = np.empty((*shape[:-3], 9, shape[-3], shape[-1]))
    for first, weight in ((0, moving), (3, by_angle)):
        mean, half = _mean(weight)[..., None, :, :], _half(weight)[..., None, :, :]
        np.multiply(mean, away_m, out=terms[..., first : first + 3, :, :])
        terms[..., first : first + 3, :, :] += half * half_m
    for place, weight in ((6, by_angle), (7, over.imag), (8, by_rest_angle)):
        terms[..., place, :, :] = _mean(weight)
    factors = np.concatenate([moved, turned, np.stack([-along, rest_phase, rest_angle], axis=-1)], axis=-1)
    slopes = (factors @ terms.reshape(*shape[:-3], 9, -1)).sum(axis=-4)
    return np.asarray(-slopes.reshape(*shape[:-5], -1, shape[-3], shape[-1]))
