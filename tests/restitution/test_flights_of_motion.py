"""Which segments of a motion fall like a free body: on splines of known accelerations."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from radargui.estimation.forward.motion_spline import SplineMotion, make_spline
from radargui.estimation.readout.free_motion import FreeMotion
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.restitution.joint_bounces import _falls, _let_go, _likely, _never_falls, _off_gravity
from radargui.restitution.settings import FLIGHTS

G = G_M_S2
RELEASE = np.array([0.0, 0.0, 0.3])


def moved(edge_s: list[float], acceleration_m_s2: list[float], thrown_m_s: float = 1.0) -> FreeMotion:
    """Return a motion that is at rest at first and thrown up after each segment, each of one vertical acceleration."""
    spline = make_spline(edge_s[0], edge_s[-1], np.array(edge_s[1:-1]))
    time = np.sort(np.concatenate([np.linspace(edge_s[0], edge_s[-1], 4000), spline.edge_s]))
    height, level, speed = np.zeros(time.size), 0.0, 0.0
    for (begin, end), a in zip(itertools.pairwise(edge_s), acceleration_m_s2, strict=True):
        since = np.clip(time - begin, 0.0, end - begin)
        height = np.where(time >= begin, level + speed * since + 0.5 * a * since**2, height)
        level, speed = float(np.interp(end, time, height)), thrown_m_s
    place = np.stack([0.01 * (time - edge_s[0]), 0.0 * time, height], axis=1)
    coefficients = np.linalg.lstsq(spline.design(time).toarray(), place, rcond=None)[0]
    return FreeMotion(SplineMotion(spline, coefficients), RELEASE, G_M_S2)


def held(push_s: float, fall_s: float, push_m_s2: float) -> FreeMotion:
    """Return a first segment that a hand pushes for a while before it falls."""
    spline = make_spline(0.0, push_s + fall_s, np.zeros(0))
    time = np.linspace(0.0, push_s + fall_s, 4000)
    early, late = np.minimum(time, push_s), np.maximum(time - push_s, 0.0)
    height = 0.5 * push_m_s2 * early**2 + push_m_s2 * push_s * late - 0.5 * G * late**2
    place = np.stack([0.0 * time, 0.0 * time, height], axis=1)
    coefficients = np.linalg.lstsq(spline.design(time).toarray(), place, rcond=None)[0]
    return FreeMotion(SplineMotion(spline, coefficients), RELEASE, G_M_S2)


def test_a_segment_is_off_gravity_by_the_share_that_it_accelerates_otherwise() -> None:
    free = moved([0.1, 0.3, 0.5, 0.7], [-G, -G + 0.7, -G - 2.0])
    found = [_off_gravity(free, number) for number in range(3)]
    assert found == pytest.approx([0.0, 0.7 / G, 2.0 / G], abs=0.002)


def test_flights_end_before_one_that_lay_or_was_carried_unless_it_is_too_short_to_tell() -> None:
    off = -G + 1.1 * FLIGHTS.about_g * G
    assert _likely(moved([0.1, 0.3, 0.5, 0.7, 0.9], [-G, -G, -G, -G]), 4) == 4
    assert _likely(moved([0.1, 0.3, 0.5, 0.7, 0.9], [-G, -G, -G, off]), 4) == 3
    assert _likely(moved([0.1, 0.3, 0.5, 0.7, 0.9], [-G, -G, off, -G]), 4) == 2
    # the first two are what is fitted at the least
    assert _likely(moved([0.1, 0.3, 0.5, 0.7, 0.9], [off, off, -G, -G]), 4) == 4
    short = FLIGHTS.shortest_fall_s - 0.005
    assert _likely(moved([0.1, 0.3, 0.5, 0.5 + short, 0.9], [-G, -G, off, -G]), 4) == 4


def test_after_a_hand_it_falls_from_the_knot_after_its_push_on() -> None:
    free = held(0.08, 0.15, 6.0)
    knot = free.segments[0].knot_s
    falls = _falls(free, 0)
    # a spline feels the end of the push for a knot to either side
    assert not falls[knot[1:] < 0.07].any()
    assert falls[(knot[:-1] > 0.10) & (knot[1:] < 0.22)].all()
    begin = _let_go(free, 0)
    assert begin is not None
    assert 0.08 < knot[begin] < 0.125
    # what falls from its first span on was let go before, and too short a fall is none
    assert _let_go(moved([0.0, 0.3], [-G]), 0) is None
    assert _let_go(held(0.08, 0.5 * FLIGHTS.shortest_fall_s, 6.0), 0) is None


def test_what_turns_round_at_a_stop_never_falls() -> None:
    assert _never_falls(moved([0.0, 0.2, 0.4], [-3.0, -G]), 0)
    assert not _never_falls(moved([0.0, 0.2, 0.4], [-G, -G]), 0)
    assert not _never_falls(held(0.08, 0.15, 6.0), 0)
    # of less than the shortest fall nobody can say so
    assert not _never_falls(moved([0.0, 0.9 * FLIGHTS.shortest_fall_s, 0.3], [-3.0, -G]), 0)
