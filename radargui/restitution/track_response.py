"""How e and g answer to what the setup leaves open of floor and clock, which move no place (method 6, Budget)."""

from collections.abc import Callable

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, CONTACT, CONTACT_S, TILT, uncertain_inputs
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Bounces
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange
from radargui.physics.contact import contact_time_s
from radargui.restitution.floor_normal import e_by_tilt


def tilt_and_clock(
    time_s: FloatArray, velocities: Callable[[], tuple[FloatArray, FloatArray]], bounces: Bounces, setup: Setup
) -> list[InputChange]:
    """Return what e changes by with a given normal's tilt and g with the clock; the track moves with neither.

    By the velocities before and after the impacts, shapes (n_impacts, 3); times (n,) are those of other changes.

    Of the floor also how long it takes to throw the sphere back, T: flights are followed on to an instant at which they
    meet below it, and gravity changes the speeds by g T e / (1 + e) and g T / (1 + e) until then, e by g T (1 - e) / v.
    T is Hertz's where the setup says of what sphere and floor are.
    """
    nothing, none, out = np.zeros((3, time_s.size)), np.zeros(len(bounces.impacts)), []
    u = {one.key: one.u for one in uncertain_inputs(setup)}
    if "normal" in setup.floor.model_fields_set and u[TILT] and bounces.impacts:
        changes = e_by_tilt(*velocities(), np.asarray(setup.floor.normal), u[TILT])
        out += [InputChange(TILT, "calibration", time_s, nothing, e, 0.0) for e in changes]
    if bounces.impacts and bounces.normal is not None:
        v, e = np.array([(one.speed_before_m_s, one.e) for one in bounces.impacts]).T
        lasts_s = contact_time_s(setup, v)
        lasts_s = np.full(v.shape, CONTACT_S) if lasts_s is None else lasts_s
        longer = expected_gravity_m_s2(setup.site) * abs(bounces.normal[2]) * lasts_s * (1.0 - e) / v
        out.append(InputChange(CONTACT, "calibration", time_s, nothing, longer, 0.0))
    if bounces.free_fall is not None:
        # true times are (1 + c) as long: velocities change alike, accelerations twice
        g = -2e-6 * u[CLOCK] * bounces.free_fall.g_m_s2
        out.append(InputChange(CLOCK, "calibration", time_s, nothing, none, g))
    return out
