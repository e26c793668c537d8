"""The antennas' polarisations as a setup means them, and whether every receiver would get a signal."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.polarization import (
    received_direction,
    strongest_polarization_deg,
    transmitted_direction,
    transverse_axes,
)
from radargui.model.radar import Radar, Receiver, Tracer, Transmitter
from radargui.model.scattering import conducting_sphere, scattered_field

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
    sphere = conducting_sphere(0.5 * tracer.diameter_m, radar.wavelength_m)
    sent, place = transmitted_direction(polarization_deg), np.array(transmitter.place_m)
    out = []
    for receiver in receivers:
        tilt, azimuth = np.radians([receiver.tilt_deg, receiver.azimuth_deg])
        u = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        h, v = transverse_axes(u, receiver.azimuth_deg)
        field = scattered_field(sphere, np.zeros((3, 1)), place, sent, receiver.distance_m * u)[:, 0]
        best = strongest_polarization_deg(field, h, v)
        own = best if receiver.polarization_deg is None else receiver.polarization_deg
        got, most = (abs(received_direction(angle, h, v) @ field) for angle in (own, best))
        out.append(ReceivedField(u, h, v, own, best, float(got / most) if most else 0.0))
    return tuple(out)
