"""Whether a sphere of another size explains a drop far better than the one stated (method 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from radargui.estimation.flights.drop_model import DropModel, minimise, robust_cost
from radargui.estimation.flights.estimate import DropEstimate, block_chi_square
from radargui.estimation.flights.prior import flights_prior
from radargui.model.arrays import FloatArray
from radargui.model.scattering import tracer_sphere
from radargui.model.setup import Setup
from radargui.motion.flights import FlightLayout

_FACTORS = (0.5, 0.5**0.5, 2.0**0.5, 2.0)
"""Tried: a radius told for a diameter or twice it, and half of that (octave). How a sphere of a third of a wavelength
scatters is no linear function of its size."""


@dataclass(frozen=True, slots=True)
class OtherDiameter:
    """The size with which the flights agree best with the signals.

    Attributes
    ----------
    setup
        The one stated, but for the diameter.
    by_m
        What is added to it.
    gain
        By how much chi-square is less with it than with the one stated.
    block_chi_square
        What it leaves, as of `DropEstimate`.
    """

    setup: Setup
    by_m: float
    gain: float
    block_chi_square: FloatArray


def other_diameter(drop: DropEstimate, setup: Setup) -> OtherDiameter | None:
    """Return the best of some other sizes; None where none is better, or where the sphere counts as a point.

    Parameters
    ----------
    drop
        By its flights, with the diameter that is stated. Each other one goes on from there.
    setup
        What states it.
    """
    if drop.model.sphere is None:
        return None
    _, unknowns, at = minimise(drop.model, drop.unknowns)
    stated, best = robust_cost(drop.model, unknowns, at), None
    for factor in _FACTORS:
        tracer = setup.tracer.model_copy(update={"diameter_m": factor * setup.tracer.diameter_m})
        other = setup.model_copy(update={"tracer": tracer})
        model, unknowns, at = minimise(_with_sphere(drop, other), drop.unknowns)
        gain = 2.0 * (stated - robust_cost(model, unknowns, at))
        if gain > (0.0 if best is None else best.gain):
            best = OtherDiameter(other, tracer.diameter_m - setup.tracer.diameter_m, gain, block_chi_square(model, at))
    return best


def _with_sphere(drop: DropEstimate, other: Setup) -> DropModel:
    """Return the model of a drop with the sphere of another setup, what it scatters and what air brakes it by."""
    model, one = drop.model, FlightLayout(1).drag
    drag = drop.flights.layout.drag
    prior = flights_prior(other, drop.flights.onset_s)
    flights = []
    for now, then in zip((model.mean.flights, model.deviation.flights), prior, strict=True):
        flights.append(now.copy())
        flights[-1][drag] = then[one]
    mean, deviation = flights
    return replace(
        model,
        sphere=None if model.sphere is None else replace(model.sphere, sphere=tracer_sphere(other.tracer, other.radar)),
        mean=model.mean._replace(flights=mean),
        deviation=model.deviation._replace(flights=deviation),
    )
