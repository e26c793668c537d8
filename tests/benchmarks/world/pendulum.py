"""A sphere on a thread: let go at one side, pushed around, or pushed from where it hangs; the air brakes it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from benchmarks.world.course import UP
from benchmarks.world.drop import Body
from benchmarks.world.profile import Array
from scipy.integrate import solve_ivp


def swing(
    body: Body,
    hang_m: Array,
    *,
    push_m_s: Array,
    push_s: float,
    decay_s: float,
    lasts_s: float,
) -> Callable[[Array], Array]:
    """Return displacements (3, n) at times (n,) since it was let go.

    The thread keeps |r| = l: r'' = f + lambda r with f all other forces over the mass and
    lambda = -(v^2 + f . r) / l^2.

    Parameters
    ----------
    hang_m
        From where the thread is held to the sphere at rest, shape (3,).
    push_m_s, push_s
        The speed that a push would give a free sphere, shape (3,), and how long it lasts from the start.
    decay_s
        In which the speed falls to 1/e by what grows with it; air's drag is beside it.
    """
    length_squared = float(hang_m @ hang_m)

    def slope(time_s: float, state: Array) -> Array:
        place, speed = state[:3], state[3:]
        brake = 1.0 / decay_s + body.braking_1_s(float(np.linalg.norm(speed)))
        force = -body.acceleration_m_s2 * UP - brake * speed
        if time_s < push_s:  # sin^2: mean 1/2, starts and ends gently
            force = force + push_m_s * 2.0 / push_s * np.sin(np.pi * time_s / push_s) ** 2
        pull = -(speed @ speed + force @ place) / length_squared
        return np.concatenate([speed, force + pull * place])

    found = solve_ivp(
        slope, (0.0, lasts_s + 0.01), np.concatenate([hang_m, np.zeros(3)]), "DOP853", dense_output=True,
        rtol=1e-11, atol=1e-13, max_step=0.01,
    )  # fmt: skip

    def offset_m(time_s: Array) -> Array:
        return np.asarray(found.sol(np.clip(time_s, 0.0, lasts_s + 0.01))[:3] - hang_m[:, None])

    return offset_m
