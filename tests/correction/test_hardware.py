"""Hardware constants pooled over runs."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.correction.hardware import HardwareConstants, front_end_prior, pool_constants


def constants(gain: float, u_gain: float, angle: float, u_angle: float) -> tuple[HardwareConstants]:
    return (HardwareConstants(gain, u_gain, angle, u_angle, (0.1, 0.2), (0.01, 0.01)),)


def test_the_pool_trusts_the_better_run_more() -> None:
    (pooled,) = pool_constants([constants(1.10, 0.001, 5.0, 0.1), constants(1.11, 0.01, 6.0, 1.0)])
    assert pooled.gain_ratio == pytest.approx(1.1001, abs=1e-4)
    assert pooled.quadrature_error_deg == pytest.approx(5.01, abs=0.01)


def test_runs_that_disagree_widen_the_pool() -> None:
    (pooled,) = pool_constants([constants(1.0, 1e-4, 0.0, 0.01), constants(1.1, 1e-4, 5.0, 0.01)])
    assert pooled.u_gain_ratio > 0.03
    assert pooled.u_quadrature_error_deg > 1.5


def test_the_prior_has_the_sign_of_the_wiring() -> None:
    prior = front_end_prior(constants(1.2, 0.012, 3.0, 0.3), -1)
    assert prior[0] == pytest.approx([np.log(1.2), 0.01, -np.radians(3.0), np.radians(0.3)])
