"""What the setup says of the floor, as residuals of a drop's flights: how it reflects, and where it is touched."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from radargui.estimation.forward.signal_model import ModelInputs
from radargui.estimation.forward.stated_floor import stated_term
from radargui.model.arrays import FloatArray
from radargui.motion.flights import Flights

if TYPE_CHECKING:
    from radargui.estimation.flights.drop_model import DropModel, Parts

U_SURFACE_M = 2e-4
"""A plate is so flat, and what reflects of it is so well what is touched."""


def stated_floor(model: DropModel, values: Parts, inputs: ModelInputs) -> tuple[FloatArray, FloatArray]:
    """Return what the setup says of the floor as residuals, (n,), and their slopes by the unknowns, (n, n_unknowns).

    Of a plate it is known that what reflects is what the sphere touches. Of a start, whose ways are free, nothing is.
    """
    stated = None if model.linear.free_ways else stated_term(values.theta, model.layout, inputs)
    if stated is None:
        return np.zeros(0), np.zeros((0, model.n_unknowns))
    residual, rows = stated.residual, np.zeros((stated.residual.size + 1, model.free.size))
    rows[:-1, model.stated.stop :] = stated.slopes
    surface, flights = model.plane.surface, Flights.of(values.flights)
    if surface is None or surface.plate is None or not flights.impact_s.size:
        return residual, model.by_unknowns(rows[:-1])
    lands_s = flights.impact_s[:1]
    place, by_flights = flights.position_and_slopes(np.nextafter(lands_s, -np.inf))
    unknown = model.layout.plane_unknowns(values.theta)[0]
    normal = model.plane.turned_normal(unknown)
    gap_m = float(model.plane.height(place, unknown)[0]) - surface.touch_m
    rows[-1, model.flights] = by_flights[..., 0] @ normal
    rows[-1, flights.layout.impacts.start] += float(normal @ flights.velocity_before_m_s()[0])
    # below the release a plane that leans is hardly higher
    rows[-1, model.stated.stop + model.layout.planes.start + 2] = -float(normal @ model.plane.normal)
    rows[-1] /= U_SURFACE_M
    return np.append(residual, gap_m / U_SURFACE_M), model.by_unknowns(rows)
