"""What runs on one hardware say together: once the setup's prior, each drop its own release, and a push is seen."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.small_setups import quick_setup

from radargui.model.setup import Setup
from radargui.model.setup_pool import RunLikelihood, SetupPrior, bumped, known_setup
from radargui.model.setup_posterior import SetupLikelihood, unknown_inputs

SETUP = changed(quick_setup(), tracer={"u_release_m": 1e-3, "u_release_scatter_m": 5e-4})
KEYS = [one.key for one in unknown_inputs(SETUP)[0]]
RELEASE = [number for number, key in enumerate(KEYS) if key.startswith("tracer.")]
TILT = KEYS.index("receiver[2].tilt_deg")
TOTAL_M = np.hypot(1e-3, 5e-4)


def truth(rng: np.random.Generator) -> np.ndarray:
    """Values in their u, off by what the setup states; of the release the part that drops share."""
    out = rng.standard_normal(len(KEYS))
    out[RELEASE] *= 1e-3 / TOTAL_M
    return out


def run_of(off: np.ndarray, rng: np.random.Generator, name: str = "run", setup: Setup = SETUP) -> RunLikelihood:
    """Six numbers about the setup, each with an error of 0.05 u."""
    here = off.copy()
    here[RELEASE] += 5e-4 / TOTAL_M * rng.standard_normal(3)
    rows = rng.standard_normal((6, off.size)) / 0.05
    measured = rows @ here + rng.standard_normal(6)
    return RunLikelihood(name, setup, SetupLikelihood.sound(rows.T @ rows, rows.T @ measured))


def test_the_prior_of_the_setup_counts_once_and_each_run_adds_to_it() -> None:
    nothing = SetupLikelihood(np.zeros((len(KEYS),) * 2), np.zeros(len(KEYS)))
    for count in (1, 5):
        prior = known_setup([RunLikelihood("a", SETUP, nothing)] * count, (), SETUP)
        assert prior is not None
        np.testing.assert_allclose(prior.covariance, np.eye(len(KEYS)), atol=1e-9)
        np.testing.assert_allclose(prior.mean, 0.0, atol=1e-12)


def test_the_truth_lies_within_what_ten_runs_say_and_a_release_keeps_its_scatter() -> None:
    pulls, sharp = [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        off = truth(rng)
        prior = known_setup([run_of(off, rng) for _ in range(10)], (), SETUP)
        assert prior is not None
        covariance = np.array(prior.covariance)
        # as a drop of its own is: with another scatter
        off[RELEASE] += 5e-4 / TOTAL_M * rng.standard_normal(3)
        away = off - prior.mean
        pulls.append(away @ np.linalg.solve(covariance, away))
        sharp.append(np.sqrt(np.diag(covariance)))
    assert np.mean(pulls) == pytest.approx(len(KEYS), rel=0.1)
    u = np.median(sharp, axis=0)
    assert u[TILT] < 0.1
    assert (u[RELEASE] > 0.99 * 5e-4 / TOTAL_M).all()


def test_a_release_stated_elsewhere_says_nothing_of_this_one_and_other_antennas_nothing_at_all() -> None:
    rng = np.random.default_rng(1)
    elsewhere = changed(SETUP, tracer={"release_position_m": (0.01, 0.0, 0.1)})
    off = truth(rng)
    prior = known_setup([run_of(off, rng, setup=elsewhere) for _ in range(10)], (), SETUP)
    assert prior is not None
    u = np.sqrt(np.diag(prior.covariance))
    assert u[RELEASE] == pytest.approx(1.0, rel=0.01)
    assert u[TILT] < 0.3
    moved = changed(SETUP, radar={"frequency_hz": 9.5e9})
    assert known_setup([run_of(off, rng, setup=moved)], (), SETUP) is None


def test_runs_that_differ_by_more_than_they_say_widen_what_they_say_together() -> None:
    rng = np.random.default_rng(2)
    off = truth(rng)
    alike = known_setup([run_of(off, rng) for _ in range(10)], (), SETUP)
    apart = known_setup([run_of(off + 0.5 * rng.standard_normal(off.size), rng) for _ in range(10)], (), SETUP)
    assert alike is not None
    assert apart is not None
    assert apart.covariance[TILT][TILT] > 4.0 * alike.covariance[TILT][TILT]


def contradiction(prior: SetupPrior, off: np.ndarray, rng: np.random.Generator) -> str:
    found = bumped(run_of(off, rng).likelihood, prior, SETUP)
    return "" if found is None else str(found.facts["place"])


def test_a_pushed_antenna_is_named_and_drops_that_agree_are_not_blamed() -> None:
    named, blamed = [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        off = truth(rng)
        prior = known_setup([run_of(off, rng) for _ in range(10)], (), SETUP)
        assert prior is not None
        blamed.append(contradiction(prior, off, rng))
        off[TILT] += 3.0
        named.append(contradiction(prior, off, rng))
    assert blamed.count("") >= 99
    assert named.count("") <= 10
    assert named.count("receiver[2]") > 40


def test_a_wavelength_of_which_a_run_knows_next_to_nothing_has_not_moved() -> None:
    rng = np.random.default_rng(5)
    off = truth(rng)
    prior = known_setup([run_of(off, rng) for _ in range(3)], (), SETUP)
    assert prior is not None
    here, wave = run_of(off, rng).likelihood, KEYS.index("radar.frequency_hz")
    # what rounding leaves where nothing is known
    matrix, vector = here.matrix.copy(), here.vector.copy()
    matrix[wave], matrix[:, wave] = 0.0, 0.0
    matrix[wave, wave], vector[wave] = 1e-12, 1e-5
    assert bumped(SetupLikelihood(matrix, vector), prior, SETUP) is None


def test_nothing_before_a_run_that_contradicts_counts_nor_what_comes_after_another_one() -> None:
    rng = np.random.default_rng(4)
    off = truth(rng)

    def run(name: str, *, begins: bool = False) -> RunLikelihood:
        return RunLikelihood(name, SETUP, run_of(off, rng).likelihood, begins)

    before, after = [run("1"), run("2", begins=True), run("3")], [run("5"), run("6", begins=True), run("7")]
    prior = known_setup(before, after, SETUP)
    assert prior is not None
    assert prior.runs == ("2", "3", "5")


def test_a_likelihood_is_what_a_posterior_adds_to_its_prior_with_the_rest_integrated_out() -> None:
    rng = np.random.default_rng(5)
    rows, deviation = rng.standard_normal((8, 5)), np.array([1.0, 1e-3, 1.0, 1.0, 0.03])
    data, rest = rows @ rng.standard_normal(5), slice(4, 5)
    precision = rows.T @ rows + np.diag(deviation**-2.0)
    covariance = np.linalg.inv(precision)
    found = SetupLikelihood.of_posterior(covariance @ rows.T @ data, covariance, deviation, 4)
    # the last, flat: what its column explains is left out of the rows
    column = rows[:, rest]
    left = np.eye(8) - column @ np.linalg.pinv(column)
    np.testing.assert_allclose(found.matrix, rows[:, :4].T @ left @ rows[:, :4], atol=1e-4)
    np.testing.assert_allclose(found.vector, rows[:, :4].T @ left @ data, atol=1e-4)
