"""Polarisation of the antennas: the field that an angle of the setup means, and what each receiver gets of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.radar import Radar, Receiver, Tracer, Transmitter
from radargui.model.scattering import conducting_sphere, scattered_field

_ON_AXIS = 1e-9  # of a unit vector: nearer to the z axis than this the horizontal direction is the azimuth's


def transmitted_direction(polarization_deg: float) -> FloatArray:
    """Return the transmitter's field direction, counted from the x axis towards the y axis; shape (3,)."""
    angle = np.radians(polarization_deg)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def transverse_axes(direction: FloatArray, azimuth_deg: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return h = unit(z x u) and v = u x h, between which a receiver's polarisation angle is counted.

    Parameters
    ----------
    direction
        Unit vector u from the centre to the antenna, shape (3,).
    azimuth_deg
        Tells h = (-sin azimuth, cos azimuth, 0) where u is the z axis itself.
    """
    horizontal = np.array([-direction[1], direction[0], 0.0])
    length = float(np.hypot(horizontal[0], horizontal[1]))
    if length < _ON_AXIS:
        azimuth = np.radians(azimuth_deg)
        horizontal, length = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0]), 1.0
    horizontal = horizontal / length
    return horizontal, np.cross(direction, horizontal)


def received_direction(polarization_deg: float, horizontal: FloatArray, vertical: FloatArray) -> FloatArray:
    """Return cos(p) h + sin(p) v, the field direction to which a receiver answers; shape (3,)."""
    angle = np.radians(polarization_deg)
    return np.asarray(np.cos(angle) * horizontal + np.sin(angle) * vertical)


def strongest_polarization_deg(field: ComplexArray, horizontal: FloatArray, vertical: FloatArray) -> float:
    """Return the angle, 0 to 180 degrees, at which a receiver gets most of a field.

    |E_h cos p + E_v sin p|^2 is largest at p = atan2(2 Re(E_h conj E_v), |E_h|^2 - |E_v|^2) / 2.

    Parameters
    ----------
    field
        Complex field vector, shape (3,).
    horizontal, vertical
        From `transverse_axes`.
    """
    along, across = complex(field @ horizontal), complex(field @ vertical)
    # of the two extremes of the ellipse of the field the longer one: atan2, not atan
    double = np.arctan2(2.0 * (along * across.conjugate()).real, abs(along) ** 2 - abs(across) ** 2)
    return float(np.degrees(double) / 2.0 % 180.0)


LEAST_SHARE = 0.05
"""Of the strongest signal from the centre: a receiver that gets less is turned across the field."""


@dataclass(frozen=True, slots=True)
class ReceivedField:
    """What one receiver gets of the field that a metal sphere in the centre scatters to it.

    Attributes
    ----------
    direction
        Unit vector u from the centre to the antenna, shape (3,).
    horizontal, vertical
        h and v, between which the polarisation counts, shape (3,).
    angle_deg, strongest_deg
        The receiver's polarisation, and the one that gets the strongest signal.
    share
        Of the strongest signal, 0 to 1.
    """

    direction: FloatArray
    horizontal: FloatArray
    vertical: FloatArray
    angle_deg: float
    strongest_deg: float
    share: float


def received_fields(
    radar: Radar, transmitter: Transmitter, receivers: Sequence[Receiver], tracer: Tracer, polarization_deg: float
) -> tuple[ReceivedField, ...]:
    """Return what each receiver gets of the field of a transmitter polarised along `polarization_deg`."""
    # not small against the wave: how it turns the field on its way to a receiver depends on its size (Mie)
    sphere = conducting_sphere(0.5 * tracer.diameter_m, radar.wavelength_m)
    sent, place = transmitted_direction(polarization_deg), np.array(transmitter.place_m)
    out = []
    for receiver in receivers:
        tilt, azimuth = np.radians([receiver.tilt_deg, receiver.azimuth_deg])
        u = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        h, v = transverse_axes(u, receiver.azimuth_deg)
        field = scattered_field(sphere, np.zeros((3, 1)), place, sent, receiver.distance_m * u)[:, 0]
        best = strongest_polarization_deg(field, h, v)
        # left out: whoever set it up turned it for the strongest signal
        own = best if receiver.polarization_deg is None else receiver.polarization_deg
        got, most = (abs(received_direction(angle, h, v) @ field) for angle in (own, best))
        out.append(ReceivedField(u, h, v, own, best, float(got / most) if most else 0.0))
    return tuple(out)
