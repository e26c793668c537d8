"""Chi-square of flights and g against changes of the setup's values: dense algebra and the evidence of a mistake."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from radargui.model.gravity import expected_gravity
from radargui.model.setup import read_setup
from radargui.restitution.setup_chi_square import SetupChiSquare
from radargui.system.resources import default_setup_path

OWN = np.array([1.0, 2.0, 2.0, 1.0])
SETUP = read_setup(default_setup_path())


def made(
    *, u_g: float = 0.004, seed: int = 1, at: np.ndarray | None = None
) -> tuple[SetupChiSquare, np.ndarray, np.ndarray, np.ndarray]:
    """Return chi-square of made flights, their cost and pull, and what g follows inputs by."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(4, 4))
    cost, pull, by_g = root @ root.T, rng.normal(size=4), 1e-3 * rng.normal(size=4)
    fit: Any = SimpleNamespace(g_m_s2=9.9, u_g_m_s2=u_g, misfit=(250.0, 200.0))
    fit.against = lambda _: (cost.copy(), pull.copy())
    fit.follow = lambda response: np.array([response])
    responses: Any = by_g.tolist()
    return (
        SetupChiSquare.of(fit, responses, OWN, np.zeros(4) if at is None else at, SETUP),
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


def test_the_least_is_that_of_the_quadratic_form() -> None:
    found, *_ = made()
    off, gain = found.least()
    form = found.cost + np.diag(found.own)
    assert form @ off == pytest.approx(-found.pull)
    assert gain == pytest.approx(-(off @ form @ off + 2.0 * found.pull @ off))
    left = found.value - gain - found.expected
    assert found.sigmas_left(gain) == pytest.approx(left / np.sqrt(2.0 * found.expected))


def test_an_estimate_that_has_moved_its_inputs_says_the_same_of_what_was_stated() -> None:
    """The same quadratic form, taken where the inputs stand and counted from where they were stated."""
    at = np.array([0.5, -1.0, 2.0, 0.1])
    here, *_ = made()
    there, *_ = made(at=at)
    for off in (np.zeros(4), at, np.array([1.0, 2.0, -1.0, 0.0])):
        from_there = off - at
        expected = here.value + 2.0 * here.pull @ from_there + from_there @ here.cost @ from_there
        assert there.value + 2.0 * there.pull @ off + off @ there.cost @ off == pytest.approx(expected)
    assert there.g_m_s2 + there.by_input @ at == pytest.approx(here.g_m_s2)


def test_without_what_is_known_of_g_flights_alone_are_left() -> None:
    found, cost, pull, by_g = made()
    expected, _ = expected_gravity(SETUP.site, SETUP.tracer.density_kg_m3)
    alone = found.without_g(expected)
    assert alone.value == pytest.approx(250.0)
    assert alone.cost == pytest.approx(cost)
    assert alone.pull == pytest.approx(pull)
    off = -np.linalg.solve(cost + np.diag(OWN), pull)
    assert alone.gravity() == pytest.approx(9.9 + by_g @ off)
    # what is known of g takes part in what is left open
    right = np.zeros(4, dtype=bool)
    of_both, of_flights = (one.posterior(right, np.zeros(4)) for one in (found, alone))
    assert np.linalg.slogdet(of_both)[1] < np.linalg.slogdet(of_flights)[1]


def test_an_input_that_is_wrong_leaves_open_all_the_way_to_where_it_belongs() -> None:
    found, *_ = made()
    wrong, at = np.array([False, True, False, False]), np.array([0.1, 0.2, 0.0, 0.0])
    away = found.least(wrong)[0] - at
    # along the way there: at least its length
    assert away @ found.posterior(wrong, at) @ away > (away @ away) ** 2
    right = found.posterior(np.zeros(4, dtype=bool), at)
    assert right == pytest.approx(np.linalg.inv(found.cost + np.diag(OWN)))
