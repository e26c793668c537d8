"""Polarisation of the antennas: the direction of the electric field that an angle of the setup means."""

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray

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
    double = np.arctan2(2.0 * (along * across.conjugate()).real, abs(along) ** 2 - abs(across) ** 2)
    return float(np.degrees(double) / 2.0 % 180.0)
