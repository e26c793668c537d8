"""How e and g of a track's bounces answer a small, smooth shift of the track: to first order, nothing is found anew.

Method 6, Budget.
"""

from collections.abc import Callable

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, CONTACT, CONTACT_S, TILT, uncertain_inputs
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Bounces, Segment, Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange
from radargui.restitution.floor_normal import e_by_tilt, normal_changes
from radargui.restitution.impact_speeds import changes_of_e
from radargui.restitution.track_flights import (
    FittedFlights,
    find_flights,
    impact_sides,
    impact_velocities,
    samples_of_flights,
    velocities_of_track,
)

LEAST_SHIFTS = 4
"""Of a flight or of what lies beside an impact: shifts have no noise, and a parabola has three coefficients."""


def respond(
    track: Track,
    segment: Segment,
    bounces: Bounces,
    shift_m: FloatArray,
    given_normal: bool,
    gravity_m_s2: float,
    u_tilt_deg: float | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the changes of all e and of g in free fall by shifts of the track.

    Parabolas are linear in the heights: a shift far below a wavelength moves no impact to another flight, and the fit
    to the shift alone is the change of the fit (GUM, 5.1.3). Where the normal was found from the impacts it moves too.

    Parameters
    ----------
    track, segment, bounces
        Of the run; the impacts and their normal stand.
    shift_m
        Shape (n_shifts, 3, n_samples) for the samples of `track`.
    given_normal
        Whether the setup says where the floor points.
    gravity_m_s2
        g of the place, as in `find_bounces`.
    u_tilt_deg
        Standard deviation of the floor's slope, as in `find_bounces`.

    Returns
    -------
    tuple
        Of e, shape (n_shifts, n_impacts), and of g in m/s^2, shape (n_shifts,); NaN where there is none to change.
    """
    e, g = np.full((shift_m.shape[0], len(bounces.impacts)), np.nan), np.full(shift_m.shape[0], np.nan)
    part = slice(segment.first, segment.last)
    time, position, shift = track.time_s[part], track.position_m[:, part], shift_m[:, :, part]
    known = track.valid[part] & np.isfinite(position).all(axis=0) & np.isfinite(shift).all(axis=(0, 1))
    if not known.all():
        time, position, shift = time[known], position[:, known], shift[..., known]
    if bounces.normal is None or not bounces.impacts or time.size < LEAST_SHIFTS:
        return e, g
    normal, impact_s = np.asarray(bounces.normal), np.array([one.time_s for one in bounces.impacts])
    height = normal @ shift
    if not given_normal:
        leaning = _normal_changes(time, position, shift, bounces, gravity_m_s2, u_tilt_deg)
        # of heights only slopes count: the first place is as good as any
        height += leaning @ (position - position[:, :1])
    last = bounces.impacts[-1].speed_after_m_s
    # as in `find_bounces`: the same flights, so that the answer is that of the same fit
    flights = find_flights(
        track.time_s[segment.first], track.time_s[segment.last - 1], impact_s, max(last, 0.0), gravity_m_s2
    )
    if (change := _changed(time, height, flights)) is not None:
        sides = np.stack(change.sides(impact_s.size))
        known, one, other = sides[:, np.isfinite([bounces.impacts[k].e for k in sides[0]])]
        before, after = np.array([(at.speed_before_m_s, at.speed_after_m_s) for at in bounces.impacts])[known].T
        own, at_s = change.parabolas, impact_s[known]
        arriving, leaving = ((own.height_at(place, at_s), own.speed_at(place, at_s)) for place in (one, other))
        e[:, known] = changes_of_e(arriving, leaving, before, after, gravity_m_s2 * float(normal[2]))
    if bounces.free_fall is not None and (fall := _changed(time, height, flights[:1])) is not None:
        # heights are along the normal: only g cos(tilt) acts there
        g = fall.parabolas.g_m_s2 / max(abs(normal[2]), 1e-9)
    return e, g


def floor_and_clock(track: Track, segment: Segment, bounces: Bounces, setup: Setup) -> list[InputChange]:
    """Return what e changes by with a given normal's tilt and g with the clock; the track moves with neither.

    Parameters
    ----------
    track, segment, bounces, setup
        As for `respond`.
    """

    def velocities() -> tuple[FloatArray, FloatArray]:
        impact_s = np.array([one.time_s for one in bounces.impacts])
        at = velocities_of_track(track, segment, impact_s, expected_gravity_m_s2(setup.site))
        return at.before_m_s, at.after_m_s

    return tilt_and_clock(track.time_s, velocities, bounces, setup)


def tilt_and_clock(
    time_s: FloatArray, velocities: Callable[[], tuple[FloatArray, FloatArray]], bounces: Bounces, setup: Setup
) -> list[InputChange]:
    """Return `floor_and_clock` at times (n,) by the velocities before and after the impacts, shapes (n_impacts, 3).

    Of the floor also how long it takes to throw the sphere back, T: flights are followed on to an instant at which they
    meet below it, and gravity changes the speeds by g T e / (1 + e) and g T / (1 + e) until then, e by g T (1 - e) / v.
    """
    nothing, none, out = np.zeros((3, time_s.size)), np.zeros(len(bounces.impacts)), []
    u = {one.key: one.u for one in uncertain_inputs(setup)}
    if "normal" in setup.floor.model_fields_set and u[TILT] and bounces.impacts:
        changes = e_by_tilt(*velocities(), np.asarray(setup.floor.normal), u[TILT])
        out += [InputChange(TILT, "calibration", time_s, nothing, e, 0.0) for e in changes]
    if bounces.impacts and bounces.normal is not None:
        v, e = np.array([(one.speed_before_m_s, one.e) for one in bounces.impacts]).T
        longer = expected_gravity_m_s2(setup.site) * abs(bounces.normal[2]) * CONTACT_S * (1.0 - e) / v
        out.append(InputChange(CONTACT, "calibration", time_s, nothing, longer, 0.0))
    if bounces.free_fall is not None:
        # true times are (1 + c) as long: velocities change alike, accelerations twice
        g = -2e-6 * u[CLOCK] * bounces.free_fall.g_m_s2
        out.append(InputChange(CLOCK, "calibration", time_s, nothing, none, g))
    return out


def _normal_changes(
    time_s: FloatArray,
    position_m: FloatArray,
    shift_m: FloatArray,
    bounces: Bounces,
    gravity_m_s2: float,
    u_tilt_deg: float | None,
) -> FloatArray:
    """Return how the normal that the impacts say leans over, shape (n_shifts, 3)."""
    impact_s = np.array([one.time_s for one in bounces.impacts])
    # weights of the impacts among each other
    at = impact_velocities(time_s, position_m, impact_s, gravity_m_s2, white=True)
    seen = np.isfinite(at.u_side_m_s) & np.array([one.valid for one in bounces.impacts])
    if not seen.any():
        return np.zeros((shift_m.shape[0], 3))
    u, before, after = at.u_side_m_s[seen], at.before_m_s[seen], at.after_m_s[seen]
    more_before, more_after = _speed_changes(time_s, shift_m, impact_s[seen])
    return normal_changes(before, after, more_before, more_after, u, u_tilt_deg)


def _speed_changes(time_s: FloatArray, shift_m: FloatArray, impact_s: FloatArray) -> FloatArray:
    """Return the changes of the velocities before and after impacts, shape (2, n_shifts, n_impacts, 3)."""
    side, impact, samples = impact_sides(time_s, impact_s)
    out = np.zeros((2, impact_s.size, *shift_m.shape[:2]))
    out[side, impact] = samples.lines(samples.of(shift_m))[1].transpose(2, 0, 1)
    return np.asarray(out.transpose(0, 2, 1, 3))


def _changed(time_s: FloatArray, height_m: FloatArray, flights_s: FloatArray) -> FittedFlights | None:
    """Return the changes of parabolas with one g by changes of the height; None where no flight is long enough.

    Parameters
    ----------
    time_s, height_m
        Known samples of the motion, shape (n_samples,), and changes, shape (n_changes, n_samples).
    flights_s
        As found, shape (n_flights, 2).
    """
    number, samples = samples_of_flights(time_s, flights_s, LEAST_SHIFTS)
    return FittedFlights.of(number, samples, samples.of(height_m)) if number.size else None
