"""The sphere as a body between polarised antennas: what it does to the direct and the mirrored paths (method 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray, IntArray
from radargui.model.assumed import SUPPOSED_POLARIZATIONS_DEG, uncertain_inputs
from radargui.model.scattering import (
    MieSphere,
    scattered_signals,
    tracer_sphere,
    transmitted_direction,
    transverse_axes,
    unit_vectors,
)
from radargui.model.setup import Setup
from radargui.physics.mirrors import MirrorPlane, has_floor
from radargui.physics.path_length import Antennas
from radargui.physics.plate import exchanged_signals

_STEP = 1e-4  # rad and m, of a mirror: differences are off by as much of what M is curved by
_SHIFT = 2  # place of a plane's shift among its unknowns
EXCHANGE, U_EXCHANGE = np.array([1.0, 0.0]), np.array([0.3, 0.3])
"""R under the sphere over R where the antennas see the floor, and by how much another spot and angle differ in it."""
_U_SUPPOSED_DEG, _U_TURNED_DEG = 20.0, 40.0
"""Of the transmitter's angle about the nearest of those supposed, and of receivers about the strongest signal."""
MIN_U_ANGLE_RAD = 1e-6  # of a polarisation that is known exactly: the unknown stays, its prior holds it


@dataclass(frozen=True, slots=True, eq=False)
class PolarisedSphere:
    """A sphere and the antennas' fields, whose angles are unknowns with a prior.

    Attributes
    ----------
    sphere
        Its scattering amplitudes.
    transmitted
        The two directions between which the transmitter's angle counts, shape (2, 3).
    received
        The same of each receiver, h and v, shape (n_receivers, 2, 3).
    angle_rad, u_angle_rad
        Prior of the transmitter's angle, then of the receivers', shape (1 + n_receivers,).
    """

    sphere: MieSphere
    transmitted: FloatArray
    received: FloatArray
    angle_rad: FloatArray
    u_angle_rad: FloatArray

    def seen_by(self, antennas: Antennas) -> PolarisedSphere:
        """Return it with the axes of receivers that have moved: their angles count between these."""
        towards = [transverse_axes(one / np.linalg.norm(one)) for one in antennas.receivers_m]
        return replace(self, received=np.array(towards))

    def fields(
        self,
        place: FloatArray,
        antennas: Antennas,
        release_m: FloatArray,
        planes: Sequence[MirrorPlane],
        mirrors: FloatArray,
    ) -> SphereFields:
        """Return what the sphere scatters along every path, for places (3, n).

        A mirror turns a field's direction as it turns a vector; the change of sign stays in T and R. What the sphere
        exchanges with a floor is part of what it scatters.

        Parameters
        ----------
        place, antennas, release_m, planes
            Geometry.
        mirrors
            Unknowns and T of the planes, then R of the exchange over T (`Layout.mirrors`), shape (5 n_planes + 2,)
            or, where it is not unknown, (5 n_planes,).
        """
        n = len(planes)
        unknown = mirrors[: 3 * n].reshape(n, 3)
        basis = self.basis(place, antennas, planes, unknown)
        first = 3 * has_floor(planes)
        steps = _STEP * np.eye(unknown.size).reshape(unknown.size, *unknown.shape)
        by_mirrors = [(self.basis(place, antennas, planes, unknown + step) - basis) / _STEP for step in steps[first:]]
        which, height = np.arange(first, unknown.size), None
        at_rest = self.basis(release_m[:, None], antennas, (), unknown[:0])[:, 0, 0, :, :, 0]
        reflection = complex(*mirrors[3 * n : 3 * n + 2]) if has_floor(planes) else 0.0
        if reflection:
            own = complex(*mirrors[5 * n :]) if mirrors.size > 5 * n else 1.0
            exchanged, by_height, by_shift, by_log = (
                _beside_walls(one, n)
                for one in self._exchanged(place, antennas, release_m, planes, unknown, own * reflection)
            )
            height = Height(planes[0].turned_normal(unknown[0]), place, by_height)
            basis = basis + exchanged
            by_mirrors = [by_shift, *by_mirrors]
            which = np.concatenate([[_SHIFT], which])
            for factor, first in ((reflection, 3 * n), (own, 5 * n))[: 1 + (mirrors.size > 5 * n)]:
                by_mirrors += [by_log / factor, 1j * by_log / factor]
                which = np.append(which, [first, first + 1])
        slopes_at = np.array(by_mirrors, complex).reshape(which.size, *basis.shape)
        axes = np.concatenate([self.transmitted[None], self.received])
        return SphereFields(basis, at_rest, slopes_at, which, mirrors[which], height, axes)

    def basis(
        self, place: FloatArray, antennas: Antennas, planes: Sequence[MirrorPlane], unknown: FloatArray
    ) -> ComplexArray:
        """Return `SphereFields.basis` without exchange; parameters as for `fields`."""
        ways = self._ways(place, antennas, planes, unknown)
        leaving, got = ways.leaving[:, None], ways.got[:, None]
        fields = scattered_signals(self.sphere, ways.incident[:, None], ways.sent[:, None], leaving, got)
        return ways.reflected(fields)

    def _exchanged(
        self,
        place: FloatArray,
        antennas: Antennas,
        release_m: FloatArray,
        planes: Sequence[MirrorPlane],
        unknown: FloatArray,
        reflection: complex,
    ) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
        """Return what the exchange adds to `basis` without walls, and its slopes by height, shift, ln R."""
        floor, own = planes[0], unknown[0]
        wavenumber = 2.0 * np.pi / self.sphere.wavelength_m
        image_m = floor.image(antennas.transmitter_m, own)
        from_image, from_antenna = release_m - image_m, release_m - antennas.transmitter_m
        way_m = np.linalg.norm(from_image) - np.linalg.norm(from_antenna)
        # T counts from the release and turns a vector; R of the plane itself is that of a conductor's image
        plain = -reflection * np.exp(-1j * wavenumber * way_m) / max(1.0, abs(reflection))
        ways, normal = self._ways(place, antennas, planes[:1], unknown[:1]), floor.turned_normal(own)
        back, (leaving, got) = (
            ways.leaving.shape[:2],
            (one.reshape(-1, *one.shape[2:]) for one in (ways.leaving, ways.got)),
        )
        height_m = floor.height(place, own)
        plate = None if floor.surface is None else floor.surface.plate
        found = exchanged_signals(self.sphere, height_m, plain, normal, ways.incident, ways.sent, leaving, got, plate)
        signal, by_height, by_log = (
            ways.reflected(np.moveaxis(one.reshape(len(ways.incident), *back, *one.shape[2:]), 1, 0))
            for one in (found.signal, found.by_height, found.by_log_reflection)
        )
        # a floor that rises comes nearer to the sphere, and its image nearer to the release
        rises = float(normal @ floor.normal)
        nearer = from_image @ floor.image_slope(antennas.transmitter_m, own)[_SHIFT] / np.linalg.norm(from_image)
        # a plane that cuts the sphere counts as if they touched: where it is moves the phase alone
        cuts = float(height_m.min()) < self.sphere.radius_m
        by_rise = 2j * wavenumber * by_log if cuts else by_height
        by_shift = 1j * wavenumber * float(nearer) * by_log - rises * by_rise
        return signal, by_height, by_shift, by_log

    def _ways(self, place: FloatArray, antennas: Antennas, planes: Sequence[MirrorPlane], unknown: FloatArray) -> _Ways:
        sent_m = np.array([antennas.transmitter_m, *self._images(antennas.transmitter_m, planes, unknown)])
        sent = np.array([self.transmitted, *self._turned(self.transmitted, planes, unknown)])
        got_m = np.array([[rx, *self._images(rx, planes, unknown)] for rx in antennas.receivers_m])
        got = np.array([[axes, *self._turned(axes, planes, unknown)] for axes in self.received])
        # two basis directions a side: angles of polarisation then cost no new sum over multipoles
        incident, leaving = unit_vectors(place - sent_m[:, :, None]), unit_vectors(got_m[..., None] - place)
        plate = planes[0].surface.plate if has_floor(planes) and planes[0].surface is not None else None
        if plate is None or plate.index is None:
            return _Ways(incident, sent, leaving, got)
        # it turns fields towards and from its normal: that is a third one
        normal, wavenumber = planes[0].turned_normal(unknown[0]), 2.0 * np.pi / self.sphere.wavelength_m
        shares = (
            plate.parts(incident[1], normal, sent[1], wavenumber),
            plate.parts(leaving[:, 1], normal, got[:, 1], wavenumber),
        )
        sent, got = (
            np.concatenate([one, np.broadcast_to(normal, (*one.shape[:-2], 1, 3))], axis=-2) for one in (sent, got)
        )
        return _Ways(incident, sent, leaving, got, shares)

    @staticmethod
    def _images(point_m: FloatArray, planes: Sequence[MirrorPlane], unknown: FloatArray) -> list[FloatArray]:
        return [plane.image(point_m, own) for plane, own in zip(planes, unknown, strict=False)]

    @staticmethod
    def _turned(axes: FloatArray, planes: Sequence[MirrorPlane], unknown: FloatArray) -> list[FloatArray]:
        return [plane.turned(axes, own) for plane, own in zip(planes, unknown, strict=True)]

    def over_mirrors(
        self, place: FloatArray, antennas: Antennas, planes: Sequence[MirrorPlane], angle_rad: FloatArray
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return M_10 and M_01 of each plane by itself, shapes (n_planes, n_receivers, n).

        Parameters
        ----------
        place
            Shape (3, n).
        antennas, planes
            The planes as a grid has them: tilts are for convergence.
        angle_rad
            Of the transmitter, then of the receivers, shape (1 + n_receivers,).
        """
        still = np.zeros(3)
        sent = _weights(angle_rad[0])[0] @ self.transmitted
        got = np.array([_weights(angle)[0] @ axes for axes, angle in zip(self.received, angle_rad[1:], strict=True)])
        low_tx = np.array([plane.image(antennas.transmitter_m, still) for plane in planes])
        low_sent = np.array([plane.turned(sent, still) for plane in planes])
        low_rx = np.array([[plane.image(rx, still) for rx in antennas.receivers_m] for plane in planes])
        low_got = np.array([plane.turned(got, still) for plane in planes])
        incident = unit_vectors(place - antennas.transmitter_m[:, None])
        leaving = unit_vectors(antennas.receivers_m[:, :, None] - place)
        low_incident = unit_vectors(place - low_tx[:, :, None])[:, None]
        low_leaving = unit_vectors(low_rx[..., None] - place)

        def signal(way_in: FloatArray, field: FloatArray, way_out: FloatArray, answer: FloatArray) -> ComplexArray:
            found = scattered_signals(self.sphere, way_in, field[..., None, :], way_out, answer[..., None, :])
            return np.asarray(found[..., 0, 0, :])

        direct = signal(incident, sent, leaving, got)
        by_transmitter = signal(low_incident, low_sent[:, None], leaving, got) / direct
        return by_transmitter, np.asarray(signal(incident, sent, low_leaving, low_got) / direct)


@dataclass(frozen=True, slots=True, eq=False)
class _Ways:
    """Ways in and out and their fields.

    Attributes
    ----------
    incident, sent
        Unit vectors, (1 + n_mirrors, 3, n), and fields, (1 + n_mirrors, 2, 3).
    leaving, got
        The same of each receiver, its number first.
    shares
        Where the first mirror is a plate that is no conductor: what it leaves of its images' fields and what it adds
        of its normal (`Plate.parts`), of the transmitter and of the receivers. The normal is the third field then.
    """

    incident: FloatArray
    sent: FloatArray
    leaving: FloatArray
    got: FloatArray
    shares: tuple[tuple[ComplexArray, ComplexArray], tuple[ComplexArray, ComplexArray]] | None = None

    def reflected(self, fields: ComplexArray) -> ComplexArray:
        """Return what antennas get over a plate of fields as over a conductor, (n_receivers, ways, ways, s, t, n)."""
        if self.shares is None:
            return fields
        (sent, sent_normal), (got, got_normal) = self.shares
        out = fields[..., :2, :, :].copy()
        out[:, 1] = sent * out[:, 1] + sent_normal[:, None] * fields[:, 1, :, 2:]
        both = out[..., :2, :].copy()
        both[:, :, 1] = got[:, None, None, None] * both[:, :, 1] + got_normal[:, None, None] * out[:, :, 1, :, 2:]
        return both


@dataclass(frozen=True, slots=True, eq=False)
class Height:
    """How the exchange with a floor changes with the height: its phase turns by twice the way.

    Attributes
    ----------
    normal
        Of the floor, along which the height counts, shape (3,).
    place_m
        Where the fields were made, shape (3, n_bins).
    by_height
        Slopes of `SphereFields.basis`, same shape.
    """

    normal: FloatArray
    place_m: FloatArray
    by_height: ComplexArray

    def change_m(self, place_m: FloatArray) -> FloatArray:
        """Return by how much places (..., 3, n_bins) are higher than where the fields were made, (..., n_bins)."""
        return np.asarray(self.normal @ (place_m - self.place_m))


@dataclass(frozen=True, slots=True, eq=False)
class SphereFields:
    """Scattered fields for each pair of the antennas' basis directions.

    The signal is bilinear in both fields: f = sum over s, t of c_s(transmitter's angle) c_t(receiver's angle) F_st,
    c = (cos, sin), so that angles and their derivatives are exact and the spheres' sums are made once a round.

    Attributes
    ----------
    basis
        F of image a of the transmitter (0: itself) and image b of the receiver, shape (n_receivers, 1 + n_mirrors, 1 +
        n_mirrors, 2, 2, n_bins).
    at_rest
        F of the direct path at the release position, shape (n_receivers, 2, 2).
    by_mirrors, which, unknown
        Slopes of `basis` by the walls' unknowns and by a floor's shift and T, which the exchange hangs on, and its
        strength, shape (n, *basis.shape); where these stand among `Layout.mirrors`; and those that it was made at.
    height
        The same of the sphere's height over a floor; None without exchange.
    axes
        The antennas' basis directions, the transmitter's first, shape (1 + n_receivers, 2, 3).
    """

    basis: ComplexArray
    at_rest: ComplexArray
    by_mirrors: ComplexArray
    which: IntArray
    unknown: FloatArray
    height: Height | None
    axes: FloatArray

    def directions(self, angle_rad: FloatArray) -> FloatArray:
        """Return the fields' directions at the antennas' angles (1 + n_receivers,): transmitter's, receiver's.

        Shape (n_receivers, 2, 3).
        """
        turned = np.array([_weights(angle)[0] @ axes for angle, axes in zip(angle_rad, self.axes, strict=True)])
        return np.stack([np.broadcast_to(turned[0], turned[1:].shape), turned[1:]], axis=1)

    def repeated(self, count: int) -> SphereFields:
        """Return the fields at the bins some times over."""
        height = self.height
        if height is not None:
            height = Height(height.normal, np.tile(height.place_m, count), np.tile(height.by_height, count))
        by_mirrors = np.tile(self.by_mirrors, count)
        return replace(self, basis=np.tile(self.basis, count), by_mirrors=by_mirrors, height=height)

    def of_bins(self, part: slice) -> SphereFields:
        """Return the fields at some of the bins."""
        height = self.height
        if height is not None:
            height = Height(height.normal, height.place_m[:, part], height.by_height[..., part])
        by_mirrors = self.by_mirrors[..., part]
        return replace(self, basis=self.basis[..., part], by_mirrors=by_mirrors, height=height)

    def moved(self, mirrors: FloatArray, place_m: FloatArray) -> SphereFields:
        """Return the fields with planes and sphere moved, linearised.

        Parameters
        ----------
        mirrors
            As `PolarisedSphere.fields` takes them.
        place_m
            Of the sphere, shape (3, n_bins), or as each receiver sees it, (n_receivers, 3, n_bins).
        """
        basis = self.basis
        if self.height is not None:
            basis = basis + self.height.change_m(place_m)[..., None, None, None, None, :] * self.height.by_height
        if self.unknown.size:
            slopes = self.by_mirrors.reshape(self.unknown.size, -1)
            by = (mirrors[self.which] - self.unknown) @ slopes.view(float)
            basis = basis + by.view(complex).reshape(self.by_mirrors.shape[1:])
        return replace(self, basis=basis)

    def mirror_slopes(self, receiver: int, transmitter_rad: float, receiver_rad: float) -> ComplexArray:
        """Return the slopes of M by the planes' unknowns and T of `which`, and by the height.

        Shape (n + 1, 1 + n_mirrors, 1 + n_mirrors, n_bins), without exchange (n, ...).
        """
        c_tx, c_rx = _weights(transmitter_rad)[0], _weights(receiver_rad)[0]
        direct = _signal(self.basis[receiver, 0, 0], c_tx, c_rx)
        slopes = self.by_mirrors[:, receiver]
        if self.height is not None:
            slopes = np.concatenate([slopes, self.height.by_height[None, receiver]])
        return _signal(slopes, c_tx, c_rx) / direct

    def factors(self, receiver: int, transmitter_rad: float, receiver_rad: float) -> SphereFactors:
        """Return what the sphere multiplies the paths to a receiver with, for angles (rad) of the antennas."""
        c_tx, c_rx = _weights(transmitter_rad)[0], _weights(receiver_rad)[0]
        field = _signal(self.basis[receiver], c_tx, c_rx)
        direct = field[0, 0]
        # M has no bound near a null of the direct path: the setup refuses receivers below 5 % of the strongest signal
        return SphereFactors(direct / complex(c_tx @ self.at_rest[receiver] @ c_rx), field / direct)

    def angle_slopes(
        self, receiver: int, transmitter_rad: float, receiver_rad: float
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return d ln direct / d angle of both antennas, (2, n_bins), and d M / d angle, (2, ..., n_bins)."""
        (c_tx, d_tx), (c_rx, d_rx) = (_weights(angle) for angle in (transmitter_rad, receiver_rad))
        basis, at_rest = self.basis[receiver], self.at_rest[receiver]
        field, rest = _signal(basis, c_tx, c_rx), complex(c_tx @ at_rest @ c_rx)
        direct = field[0, 0]
        by_direct, by_mirrored = [], []
        for s, t in ((d_tx, c_rx), (c_tx, d_rx)):
            change = _signal(basis, s, t) / direct
            # what turns the field at release as well is phase and amplitude there: phi_0 and ln A have it
            by_direct.append(change[0, 0] - complex(s @ at_rest @ t) / rest)
            by_mirrored.append(change - field / direct * change[0, 0])
        return np.array(by_direct), np.array(by_mirrored)


@dataclass(frozen=True, slots=True, eq=False)
class SphereFactors:
    """What the sphere multiplies the paths to one receiver with.

    Attributes
    ----------
    direct
        f(p) / f(p0) of the direct path, shape (n_bins,).
    mirrored
        M_ab = f(image a of tx, image b of rx) / f(direct), shape (1 + n_mirrors, 1 + n_mirrors, n_bins).
    """

    direct: ComplexArray
    mirrored: ComplexArray

    def of_bins(self, part: slice) -> SphereFactors:
        """Return those at some of the bins."""
        return SphereFactors(self.direct[part], self.mirrored[..., part])


def point_factors(n_mirrors: int) -> SphereFactors:
    """Return the factors of a point: one on every path, at any bin."""
    ones = np.ones((1 + n_mirrors, 1 + n_mirrors, 1), complex)
    return SphereFactors(ones[0, 0], ones)


def _beside_walls(fields: ComplexArray, n_mirrors: int) -> ComplexArray:
    """Return fields over a floor among those over all mirrors: what is sent to and fro and over a wall is left out."""
    out = np.zeros((len(fields), 1 + n_mirrors, 1 + n_mirrors, *fields.shape[3:]), complex)
    out[:, :2, :2] = fields
    return out


def signals_of(basis: ComplexArray, transmitter_rad: float, receiver_rad: FloatArray) -> ComplexArray:
    """Return what each receiver gets of every pair of ways, (n_receivers, 1 + n_mirrors, 1 + n_mirrors, n_bins).

    Parameters
    ----------
    basis
        As in `SphereFields`.
    transmitter_rad, receiver_rad
        Angles of the antennas, the receivers' of shape (n_receivers,).
    """
    sent = _weights(transmitter_rad)[0]
    return np.array([_signal(one, sent, _weights(angle)[0]) for one, angle in zip(basis, receiver_rad, strict=True)])


def polarised_sphere(setup: Setup) -> PolarisedSphere | None:
    """Return the sphere of a setup, None where it says nothing of the polarisation: then it counts as a point.

    A receiver without an angle is turned for the strongest signal from the centre.
    """
    if setup.transmitter.polarization_deg is None:
        return None
    fields = setup.received_fields()
    angles = [setup.transmitter.polarization_deg, *(own.angle_deg for own in fields)]
    # stated or assumed: the data find what is only guessed (10 degrees off and held cost 0.085 mm)
    u_deg = [one.u for one in uncertain_inputs(setup) if one.key.endswith(".polarization_deg")]
    return PolarisedSphere(
        tracer_sphere(setup.tracer, setup.radar),
        np.stack([transmitted_direction(0.0), transmitted_direction(90.0)]),
        np.array([[own.horizontal, own.vertical] for own in fields]),
        np.radians(angles),
        np.maximum(np.radians(u_deg), MIN_U_ANGLE_RAD),
    )


def supposed_spheres(setup: Setup) -> list[PolarisedSphere]:
    """Return the sphere between antennas polarised in some ways: a setup that does not tell how leaves all open.

    Receivers are then turned for the strongest signal, more or less.
    """
    out = []
    for angle_deg in SUPPOSED_POLARIZATIONS_DEG:
        turned = setup.transmitter.model_copy(update={"polarization_deg": angle_deg})
        sphere = polarised_sphere(setup.model_copy(update={"transmitter": turned}))
        if sphere is not None:
            u_angle = np.radians([_U_SUPPOSED_DEG, *[_U_TURNED_DEG] * len(setup.receiver)])
            out.append(replace(sphere, u_angle_rad=u_angle))
    return out


def _weights(angle_rad: float) -> tuple[FloatArray, FloatArray]:
    """Return (cos, sin) of an angle, and their derivative."""
    # a linear polarisation is a vector: after 180 degrees it is minus itself, which phi_0 takes
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([c, s]), np.array([-s, c])


def _signal(basis: ComplexArray, of_transmitter: FloatArray, of_receiver: FloatArray) -> ComplexArray:
    """Return sum over s, t of a_s b_t F_st."""
    pairs = basis.reshape(*basis.shape[:-3], 4, basis.shape[-1])
    # real weights of complex numbers, as a product of real matrices: a quarter of the time
    return np.asarray((np.outer(of_transmitter, of_receiver).ravel() @ pairs.view(float)).view(complex))
