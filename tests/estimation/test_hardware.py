"""Hardware constants pooled over runs, contradicted, and known better than a run knows them."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.estimation.hardware import as_prior, knows_more, pool_constants
from radargui.model.front_end import FrontEnd


def test_the_pool_trusts_the_better_run_more() -> None:
    (pooled,) = pool_constants([(FrontEnd(1.10, 0.001, 5.0, 0.1),), (FrontEnd(1.11, 0.01, 6.0, 1.0),)])
    assert pooled.gain_ratio == pytest.approx(1.1001, abs=1e-4)
    assert pooled.quadrature_error_deg == pytest.approx(5.01, abs=0.01)


def test_a_pool_is_known_to_its_mean_and_to_what_a_front_end_may_change() -> None:
    (pooled,) = pool_constants([(FrontEnd(1.0, 3e-3, 4.0, 0.12),)])
    assert pooled.u_gain_ratio == pytest.approx(np.hypot(3e-3, 1e-3))
    assert pooled.u_quadrature_error_deg == pytest.approx(np.hypot(0.12, 0.05))


def test_runs_that_disagree_widen_the_pool() -> None:
    (pooled,) = pool_constants([(FrontEnd(1.0, 1e-4, 0.0, 0.01),), (FrontEnd(1.1, 1e-4, 5.0, 0.01),)])
    assert pooled.u_gain_ratio > 0.03
    assert pooled.u_quadrature_error_deg > 1.5


@pytest.mark.parametrize(
    ("u_gain", "u_angle", "knows"), [(0.003, 0.15, False), (0.005, 0.15, True), (0.003, 0.3, True)]
)
def test_a_prior_counts_where_it_is_twice_as_certain(u_gain: float, u_angle: float, knows: bool) -> None:
    prior = FrontEnd(1.1, 0.002, 4.0, 0.1)
    assert knows_more([prior], [FrontEnd(1.1, u_gain, 4.0, u_angle)]) is knows


def test_harmonics_are_pooled_as_gain_and_quadrature_are_and_runs_that_know_none_are_left_out() -> None:
    first = FrontEnd(1.0, 1e-3, 0.0, 0.1, (1e-3, 0.0, -2e-3, 0.0), (1e-4, 1e-4, 2e-4, 2e-4))
    second = FrontEnd(1.0, 1e-3, 0.0, 0.1, (1.2e-3, 1e-4, -2e-3, 0.0), (1e-4, 1e-4, 2e-4, 2e-4))
    (pooled,) = pool_constants([(first,), (FrontEnd(1.0, 1e-3, 0.0, 0.1),), (second,)])
    assert pooled.harmonics == pytest.approx((1.1e-3, 5e-5, -2e-3, 0.0))
    # the root of two runs, and what a mixer may change between them
    assert pooled.u_harmonics[2] == pytest.approx(np.hypot(2e-4 / np.sqrt(2.0), 1e-4))
    (prior,) = as_prior((pooled,))
    assert prior.harmonics == pooled.harmonics
    # Q inverted turns the echo backwards
    assert first.with_phase_sign(-1).harmonics == (1e-3, -0.0, -2e-3, -0.0)
    (none,) = pool_constants([(FrontEnd(1.0, 1e-3, 0.0, 0.1),)])
    assert none.harmonics == ()
