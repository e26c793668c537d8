"""Chi-square of flights and g against changes of the setup's values: dense algebra and the evidence of a mistake."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from radargui.model.resources import default_setup_path
from radargui.model.setup import read_setup
from radargui.restitution.setup_chi_square import _MISTAKE, SetupChiSquare

KEYS = ("a", "b", "b", "c")


def made(*, u_g: float = 0.004, seed: int = 1) -> tuple[SetupChiSquare, np.ndarray, np.ndarray, np.ndarray]:
    """Return chi-square of made flights, their cost and pull, and what g follows inputs by."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(4, 4))
    cost, pull, by_g = root @ root.T, rng.normal(size=4), 1e-3 * rng.normal(size=4)
    fit: Any = SimpleNamespace(g_m_s2=9.9, u_g_m_s2=u_g, misfit=(250.0, 200.0))
    fit.against = lambda _: (cost.copy(), pull.copy())
    fit.follow = lambda response: np.array([response])
    responses: Any = by_g.tolist()
    return (
        SetupChiSquare.of(fit, KEYS, responses, read_setup(default_setup_path()), np.zeros(4, dtype=bool)),
        cost,
        pull,
        by_g,
    )


def test_g_of_the_flights_counts_as_one_more_difference_by_what_both_are_known_to() -> None:
    found, cost, pull, by_g = made()
    other, *_ = made(u_g=0.4)
    # what both say of the same difference gives the weights of either
    weight = (found.value - 250.0, other.value - 250.0)
    added = found.cost - cost
    share = added[0, 0] / by_g[0] ** 2
    assert added == pytest.approx(share * np.outer(by_g, by_g))
    off = (found.pull - pull)[1] / by_g[1] / share
    assert weight[0] == pytest.approx(share * off**2)
    wide = (other.cost - cost)[0, 0] / by_g[0] ** 2
    assert 1.0 / wide - 1.0 / share == pytest.approx(0.4**2 - 0.004**2, rel=1e-6)
    # of several things with one key one is true: they share its u
    assert found.own.tolist() == [1.0, 2.0, 2.0, 1.0]


def test_the_least_is_that_of_the_quadratic_form() -> None:
    found, *_ = made()
    off, gain = found.least()
    form = found.cost + np.diag(found.own)
    assert form @ off == pytest.approx(-found.pull)
    assert gain == pytest.approx(-(off @ form @ off + 2.0 * found.pull @ off))
    left = found.value - gain - found.expected
    assert found.sigmas_left(gain) == pytest.approx(left / np.sqrt(2.0 * found.expected))


def test_the_evidence_of_a_mistake_is_that_of_two_gaussians() -> None:
    found, *_ = made()
    which = np.array([False, True, False, False])
    square, gained = found.misstated(which)

    def log_evidence(own: np.ndarray) -> float:
        # exp(-x cost x / 2 - pull x) over x of the variances 1 / own
        variance, u = np.diag(1.0 / own), np.linalg.inv(found.cost)
        mean = -u @ found.pull
        return 0.5 * float(
            found.pull @ u @ found.pull
            - mean @ np.linalg.solve(u + variance, mean)
            - np.linalg.slogdet(u + variance)[1]
            + np.linalg.slogdet(u)[1]
        )

    mistaken = np.where(which, _MISTAKE**-2.0, found.own)
    assert gained == pytest.approx(log_evidence(mistaken) - log_evidence(found.own))
    normal = found.cost + np.diag(mistaken)
    mean = -np.linalg.solve(normal, found.pull)
    assert square == pytest.approx(mean**2 + np.diag(np.linalg.inv(normal)))
