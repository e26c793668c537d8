"""A sphere thrown up: pushed, in flight, then caught softly or falling onto the floor."""

from __future__ import annotations

import numpy as np
from benchmarks.world.course import UP, Course
from benchmarks.world.drop import Body, Floor, fall, flight
from benchmarks.world.profile import Array, Profile, Span


def thrown(
    rng: np.random.Generator,
    body: Body,
    *,
    speed_m_s: Array,
    push_s: float,
    floor: Floor | None,
    caught_within_m: float,
    lasts_s: float,
) -> Course:
    """Return the course: a gentle push along the speed (3,), then flight.

    Parameters
    ----------
    floor
        What it falls onto, counted from where it rests; None: a hand catches it where it was let go.
    caught_within_m
        The way on which the hand takes the speed away, gently.
    """
    speed = float(np.linalg.norm(speed_m_s))
    direction = speed_m_s / speed
    push = Profile((Span(push_s, speed, gentle=True),))
    let_go = direction * push.way(np.array([push_s]))[0]
    if floor is not None:
        drop = fall(rng, body, floor, let_go, start_s=push_s, duration_s=lasts_s, velocity_m_s=speed_m_s)
        free, impacts = drop.position, drop.impacts
        touch_m, normal, breaks_s = floor.touch_m, floor.normal, drop.breaks_s
    else:
        fly_s, dense = flight(body, Floor(UP, let_go, 0.0), let_go, speed_m_s)
        met, arriving = np.split(dense(fly_s), 2)
        taken = float(np.linalg.norm(arriving))
        stop_s = 2.0 * caught_within_m / taken
        # the mean of 1 - s^2 (3 - 2 s) is a half
        catch = Profile((Span(stop_s, 0.0, gentle=True),), start=taken)
        impacts, touch_m, normal, breaks_s = (), None, None, (push_s, push_s + fly_s)

        def free(time_s: Array) -> Array:
            since = time_s - push_s
            caught = met[:, None] + np.outer(arriving / taken, catch.way(since - fly_s))
            return np.where(since < fly_s, dense(np.clip(since, 0.0, fly_s))[:3], caught)

    def offset_m(time_s: Array) -> Array:
        pushed = np.outer(direction, push.way(np.minimum(time_s, push_s)))
        return np.where(time_s < push_s, pushed, free(time_s))

    return Course(offset_m, lasts_s, impacts, falls=True, touch_m=touch_m, normal=normal, breaks_s=breaks_s)
