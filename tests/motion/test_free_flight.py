"""Free flight with drag against numerical integration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from radargui.motion.free_flight import drift_time, fall_below_apex, speed_below_apex


@pytest.mark.parametrize("slow", [0.0, 0.3])
@pytest.mark.parametrize("direction", [-1.0, 1.0])
def test_the_apex_form_solves_the_equation_of_motion(direction: float, slow: float) -> None:
    g, k, length = 9.81, 0.06, 0.25

    def rate(_t: float, s: np.ndarray) -> list[float]:
        return [s[1], -g - k * (abs(s[1]) + slow) * s[1]]

    solution = solve_ivp(rate, (0.0, direction * length), [0.0, 0.0], rtol=1e-11, atol=1e-14)
    d = direction * length
    assert fall_below_apex(np.array([d]), g, k, slow)[0] == pytest.approx(
        -solution.y[0, -1], abs=2e-7 if slow else 2e-8
    )
    assert speed_below_apex(d, g, k, slow) == pytest.approx(solution.y[1, -1], abs=5e-6 if slow else 1e-6)


def test_drag_shortens_the_sideways_way() -> None:
    t = np.linspace(0.0, 0.2, 50)
    height = 1.0 - 4.9 * t**2
    assert drift_time(t, height, 0.0) == pytest.approx(t)
    assert drift_time(t, height, 0.06)[-1] < t[-1]
    assert drift_time(t, height, 0.06, 0.3)[-1] < drift_time(t, height, 0.06)[-1]
