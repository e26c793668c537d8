"""Impacts on the floor at which, or milliseconds from which, a wall was met, too: what each did is not told apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.model.arrays import BoolArray, FloatArray
from radargui.restitution.flight_fit import FlightFit, FlightInputs


@dataclass(frozen=True, slots=True)
class ImpactWallSettings:
    """When an impact is not the floor's alone. Chosen by hand.

    Attributes
    ----------
    missed
        Flights that do not meet at their impact by chi-square above this, of two degrees of freedom: one impact in
        3e5. Of 240 impacts of laboratory drops it was at most 11; with a wall 1.5 ms before the floor 45.
    latest_s, min_along
        They would meet within this (farther off a wall has a break of its own), and miss each other along the
        velocity's jump: the cosine between them is above this, for the floor may kick, too.
    min_kick_m_s
        Of a jump of the velocity along the floor: what a wall rubs is less than its kick, and a mirror that is not in
        the model displaces flights, too: by 19 um at a jump of 3 mm/s in one drop.
    same_way, same_place_m
        A kick is that of a wall known where the cosine between them is above the first, and the places are less than
        the second apart along the wall's own kick, which friction turns from its normal.
    """

    missed: float = 25.0
    latest_s: float = 0.022
    min_along: float = 0.5
    min_kick_m_s: float = 0.02
    same_way: float = 0.7
    same_place_m: float = 0.003


IMPACT_WALLS = ImpactWallSettings()


def walls_at_impacts(
    posterior: MotionPosterior, fit: FlightFit | None, normal: FloatArray, inputs: FlightInputs | None = None
) -> BoolArray:
    """Return at which breaks of a motion the floor is not alone, shape (n_breaks,).

    A wall rubs: with a share of its kick it changes the speed along the floor's normal, and e is not the floor's. It
    shows

    * where the flights before and after do not meet, but would some milliseconds beside the impact;
    * where no flights were fitted, by lines that do so (`MotionPosterior.kicks_beside`);
    * where a wall was met elsewhere in the run, and the body is there again: it is kicked as it was then.

    Parameters
    ----------
    posterior, fit
        The motion, and its flights where there are any.
    normal
        Floor's normal, shape (3,).
    inputs
        Of the setup: flights that their u makes miss each other met no wall.
    """
    breaks, speeds = posterior.breaks, posterior.breaks.along(normal)
    out = np.zeros(breaks.time_s.size, dtype=np.bool_)
    out[posterior.kicks_beside(normal)] = True
    if fit is not None:
        out[: fit.impact_s.size] = _missed(fit, normal, inputs)
    return (out | _at_known_walls(posterior, normal)) & speeds.are_impacts()


def _at_known_walls(posterior: MotionPosterior, normal: FloatArray) -> BoolArray:
    """Return which breaks have a kick along the floor as another one has that is a wall alone, at its place."""
    breaks, speeds = posterior.breaks, posterior.breaks.along(normal)
    kicks = speeds.are_kicks()
    walls = kicks & ~speeds.are_impacts()
    kick = (breaks.after_m_s - breaks.before_m_s) @ (np.eye(3) - np.outer(normal, normal))
    way = kick / np.maximum(np.linalg.norm(kick, axis=1), 1e-12)[:, None]
    place = posterior.free.position_m(breaks.time_s).T
    apart = np.abs(((place[:, None] - place[None, walls]) * way[walls]).sum(axis=2))
    # it comes towards the wall and leaves it
    turns = (breaks.before_m_s @ way[walls].T < 0.0) & (breaks.after_m_s @ way[walls].T > 0.0)
    again = turns & (way @ way[walls].T > IMPACT_WALLS.same_way) & (apart < IMPACT_WALLS.same_place_m)
    return np.asarray(kicks & again.any(axis=1))


def _missed(fit: FlightFit, normal: FloatArray, inputs: FlightInputs | None) -> BoolArray:
    """Return which impacts the flights before and after miss along the floor, but would meet beside, (n_impacts,).

    All flights after an impact are displaced by d along the floor; d = -M^-1 s, s the slope of -ln L there and M its
    curvature, the flights' own unknowns and the setup's inputs marginalised. Chi-square s^T M^-1 s is what it gains.
    """
    misfit, freedom = fit.misfit
    misfit -= 0.0 if inputs is None else inputs.gained
    kick = fit.after_m_s - fit.before_m_s
    along = np.linalg.svd(normal[None])[2][1:]
    out = np.zeros(fit.impact_s.size, dtype=np.bool_)
    for number in range(out.size):
        slope, curvature = fit.displaced_after(number, along, inputs)
        away = -np.linalg.solve(curvature, slope)
        gained = float(-slope @ away)
        # what else the flights miss widens this, too
        gained /= max(1.0, (misfit - gained) / freedom)
        jump = along @ kick[number]
        strength, late = float(np.linalg.norm(jump)), abs(float(away @ jump))
        least = IMPACT_WALLS.min_along * float(np.linalg.norm(away)) * strength
        beside = least < late < IMPACT_WALLS.latest_s * strength**2
        out[number] = gained > IMPACT_WALLS.missed and strength > IMPACT_WALLS.min_kick_m_s and beside
    return out
