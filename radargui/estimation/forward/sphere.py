"""The sphere as a body between polarised antennas: what it does to the direct and the mirrored paths (method 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.mirrors import MirrorPlane
from radargui.geometry.antennas import Antennas
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.assumed import uncertain_inputs
from radargui.model.polarization import transmitted_direction
from radargui.model.scattering import ConductingSphere, conducting_sphere, scattered_field
from radargui.model.setup import Setup

LEAST_U_ANGLE_RAD = 1e-6  # of a polarisation that is known exactly: the unknown stays, its prior holds it


@dataclass(frozen=True, slots=True, eq=False)
class PolarisedSphere:
    """A conducting sphere and the antennas' fields, whose angles are unknowns with a prior.

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

    sphere: ConductingSphere
    transmitted: FloatArray
    received: FloatArray
    angle_rad: FloatArray
    u_angle_rad: FloatArray

    def fields(
        self,
        place: FloatArray,
        antennas: Antennas,
        release_m: FloatArray,
        planes: Sequence[MirrorPlane],
        unknown: FloatArray,
    ) -> SphereFields:
        """Return what the sphere scatters along every path, for places (3, n) and the planes' unknowns.

        A mirror turns a field's direction as it turns a vector; the change of sign stays in T and R.
        """
        n_paths = 1 + len(planes)
        n_receivers = antennas.n_receivers
        sent = [(antennas.transmitter_m, self.transmitted)]
        sent += [
            (plane.image(antennas.transmitter_m, own), plane.turned(self.transmitted, own))
            for plane, own in zip(planes, unknown, strict=True)
        ]
        basis = np.empty((n_receivers, n_paths, n_paths, 2, 2, place.shape[1]), complex)
        at_rest = np.empty((n_receivers, 2, 2), complex)
        # two basis directions a side: angles of polarisation then cost no new sum over multipoles
        for receiver, (rx, axes) in enumerate(zip(antennas.receivers_m, self.received, strict=True)):
            got = [(rx, axes)]
            got += [(plane.image(rx, own), plane.turned(axes, own)) for plane, own in zip(planes, unknown, strict=True)]
            for a, (tx, directions) in enumerate(sent):
                for b, (at, toward) in enumerate(got):
                    for s, direction in enumerate(directions):
                        basis[receiver, a, b, s] = toward @ scattered_field(self.sphere, place, tx, direction, at)
            for s, direction in enumerate(self.transmitted):
                field = scattered_field(self.sphere, release_m[:, None], antennas.transmitter_m, direction, rx)
                at_rest[receiver, s] = (axes @ field)[:, 0]
        return SphereFields(basis, at_rest)

    def over_mirror(
        self, place: FloatArray, antennas: Antennas, plane: MirrorPlane, angle_rad: FloatArray
    ) -> list[tuple[ComplexArray, ComplexArray]]:
        """Return M_10 and M_01 of each receiver for places (3, n) and the antennas' angles (1 + n_receivers,)."""
        still, out = np.zeros(3), []
        sent, tx = _weights(angle_rad[0])[0] @ self.transmitted, antennas.transmitter_m
        # the plane as the grid has it: tilts are for convergence
        low_sent, low_tx = plane.turned(sent, still), plane.image(tx, still)
        for rx, axes, angle in zip(antennas.receivers_m, self.received, angle_rad[1:], strict=True):
            got = _weights(angle)[0] @ axes
            low_got, low_rx = plane.turned(got, still), plane.image(rx, still)
            direct = got @ scattered_field(self.sphere, place, tx, sent, rx)
            by_transmitter = got @ scattered_field(self.sphere, place, low_tx, low_sent, rx)
            by_receiver = low_got @ scattered_field(self.sphere, place, tx, sent, low_rx)
            out.append((by_transmitter / direct, by_receiver / direct))
        return out


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
    """

    basis: ComplexArray
    at_rest: ComplexArray

    def of_bins(self, part: slice) -> SphereFields:
        """Return the fields at some of the bins."""
        return SphereFields(self.basis[..., part], self.at_rest)

    def factors(self, receiver: int, transmitter_rad: float, receiver_rad: float) -> SphereFactors:
        """Return what the sphere multiplies the paths to a receiver with, for the angles of both antennas."""
        (c_tx, d_tx), (c_rx, d_rx) = (_weights(angle) for angle in (transmitter_rad, receiver_rad))
        basis, at_rest = self.basis[receiver], self.at_rest[receiver]
        field, rest = _signal(basis, c_tx, c_rx), complex(c_tx @ at_rest @ c_rx)
        direct = field[0, 0]
        # M has no bound near a null of the direct path: the setup refuses receivers below 5 % of the strongest signal
        mirrored = field / direct
        by_direct, by_mirrored = [], []
        for s, t in ((d_tx, c_rx), (c_tx, d_rx)):
            change = _signal(basis, s, t) / direct
            # what turns the field at release as well is phase and amplitude there: phi_0 and ln A have it
            by_direct.append(change[0, 0] - complex(s @ at_rest @ t) / rest)
            by_mirrored.append(change - mirrored * change[0, 0])
        return SphereFactors(direct / rest, mirrored, np.array(by_direct), np.array(by_mirrored))


@dataclass(frozen=True, slots=True, eq=False)
class SphereFactors:
    """What the sphere multiplies the paths to one receiver with.

    Attributes
    ----------
    direct
        f(p) / f(p0) of the direct path, shape (n_bins,).
    mirrored
        M_ab = f(image a of tx, image b of rx) / f(direct), shape (1 + n_mirrors, 1 + n_mirrors, n_bins).
    direct_slopes
        d ln direct / d angle of transmitter and receiver, shape (2, n_bins).
    mirrored_slopes
        d M / d angle, shape (2, 1 + n_mirrors, 1 + n_mirrors, n_bins).
    """

    direct: ComplexArray
    mirrored: ComplexArray
    direct_slopes: ComplexArray
    mirrored_slopes: ComplexArray


def point_factors(n_mirrors: int) -> SphereFactors:
    """Return the factors of a point: one on every path, at any bin."""
    ones = np.ones((1 + n_mirrors, 1 + n_mirrors, 1), complex)
    return SphereFactors(ones[0, 0], ones, np.zeros((0, 1), complex), np.zeros((0, *ones.shape), complex))


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
        conducting_sphere(setup.tracer.diameter_m / 2.0, setup.radar.wavelength_m),
        np.stack([transmitted_direction(0.0), transmitted_direction(90.0)]),
        np.array([[own.horizontal, own.vertical] for own in fields]),
        np.radians(angles),
        np.maximum(np.radians(u_deg), LEAST_U_ANGLE_RAD),
    )


def _weights(angle_rad: float) -> tuple[FloatArray, FloatArray]:
    """Return (cos, sin) of an angle, and their derivative."""
    # a linear polarisation is a vector: after 180 degrees it is minus itself, which phi_0 takes
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([c, s]), np.array([-s, c])


def _signal(basis: ComplexArray, of_transmitter: FloatArray, of_receiver: FloatArray) -> ComplexArray:
    """Return sum over s, t of a_s b_t F_st."""
    s, t = of_transmitter, of_receiver
    return np.asarray(
        s[0] * (t[0] * basis[..., 0, 0, :] + t[1] * basis[..., 0, 1, :])
        + s[1] * (t[0] * basis[..., 1, 0, :] + t[1] * basis[..., 1, 1, :])
    )
