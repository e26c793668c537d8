"""Hardware constants pooled over runs, taken apart again, and contradicted."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.correction.hardware import disagreement, front_end_prior, pool_constants, without_prior
from radargui.model.front_end import FrontEnd


def test_the_pool_trusts_the_better_run_more() -> None:
    (pooled,) = pool_constants([(FrontEnd(1.10, 0.001, 5.0, 0.1),), (FrontEnd(1.11, 0.01, 6.0, 1.0),)])
    assert pooled.gain_ratio == pytest.approx(1.1001, abs=1e-4)
    assert pooled.quadrature_error_deg == pytest.approx(5.01, abs=0.01)


def test_runs_that_disagree_widen_the_pool() -> None:
    (pooled,) = pool_constants([(FrontEnd(1.0, 1e-4, 0.0, 0.01),), (FrontEnd(1.1, 1e-4, 5.0, 0.01),)])
    assert pooled.u_gain_ratio > 0.03
    assert pooled.u_quadrature_error_deg > 1.5


def test_the_prior_has_the_sign_of_the_wiring() -> None:
    prior = front_end_prior((FrontEnd(1.2, 0.012, 3.0, 0.3),), -1)
    assert prior[0] == pytest.approx([np.log(1.2), 0.01, -np.radians(3.0), np.radians(0.3)])


def found_with(prior: FrontEnd, gain: float, u_gain: float, angle: float, u_angle: float) -> FrontEnd:
    """Return what a run that by itself says (gain, angle) gives with a prior; u of both are quoted times 1.5."""

    def joined(own: float, u: float, before: float, u_before: float) -> tuple[float, float]:
        precise, known = (1.5 / u) ** 2, u_before**-2.0
        return (precise * own + known * before) / (precise + known), 1.5 / np.sqrt(precise + known)

    return FrontEnd(
        *joined(gain, u_gain, prior.gain_ratio, prior.u_gain_ratio),
        *joined(angle, u_angle, prior.quadrature_error_deg, prior.u_quadrature_error_deg),
    )


def test_what_a_run_says_by_itself_is_recovered() -> None:
    prior = FrontEnd(1.1, 0.002, 4.0, 0.1)
    own = without_prior(found_with(prior, 1.104, 0.003, 3.8, 0.2), prior)
    assert (own.gain_ratio, own.u_gain_ratio) == pytest.approx((1.104, 0.003))
    assert (own.quadrature_error_deg, own.u_quadrature_error_deg) == pytest.approx((3.8, 0.2))


def test_a_run_contradicts_a_prior_only_beyond_what_both_do_not_know() -> None:
    prior = FrontEnd(1.1, 0.002, 4.0, 0.1)
    agrees = found_with(prior, 1.108, 0.003, 4.4, 0.2)
    assert disagreement([agrees], [prior]) == ""
    assert disagreement([prior], [prior]) == ""
    gain = found_with(prior, 1.12, 0.003, 4.0, 0.2)
    assert disagreement([agrees, gain], [prior, prior]) == "receiver 2: gain Q/I 1.120 here, 1.100 before"
    angle = found_with(prior, 1.1, 0.003, 2.0, 0.2)
    assert "quadrature error 2.00 degrees here, 4.00 before" in disagreement([angle], [prior])
