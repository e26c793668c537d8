"""Chi-square of flights, g and the setup's own values where those are off, as a quadratic form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.gravity import expected_gravity
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupLikelihood
from radargui.restitution.path_fit import FittedPaths, SharedPrior

if TYPE_CHECKING:
    # the window, which starts with this, asks for no estimate yet
    from radargui.estimation.posterior.input_response import InputResponse
    from radargui.restitution.flight_fit import FlightFit

_FREE = 1e-6
"""Weight of the square of an input that is freed: what nothing shows stays where it is."""
_NOISE = 2.0
"""Deviations that chi-square may be above its mean by chance."""


@dataclass(frozen=True, slots=True)
class SetupChiSquare:
    """Where inputs are off by a (in their u), chi-square is value + 2 pull.a + a^T cost a + sum of own a^2.

    value + 2 pull.a + a^T cost a = misfit + 2 c.a + a^T B a + (g - g0 + g'.a)^2 / u^2, the flights' form (method 6).

    Attributes
    ----------
    value, expected
        Of flights and g with the setup as it is, and the degrees of freedom of the flights.
    cost, pull
        Shapes (n, n) and (n,).
    own
        Weights of the inputs' own squares, shape (n,).
    g_m_s2, by_input
        g of the flights with the setup as it is, and what each input adds to it, shape (n,).
    weight
        Of what is known of g, 1/u^2.
    """

    value: float
    expected: int
    cost: FloatArray
    pull: FloatArray
    own: FloatArray
    g_m_s2: float
    by_input: FloatArray
    weight: float

    @classmethod
    def of(
        cls, fit: FlightFit, responses: Sequence[InputResponse], own: FloatArray, at: FloatArray, setup: Setup
    ) -> SetupChiSquare:
        """Return that of fitted flights.

        Parameters
        ----------
        fit
            Of the flights.
        responses, own
            Of the inputs, and the weights of their own squares, shape (n,).
        at
            Where the inputs stand in the estimate, in their u from what is stated, shape (n,).
        setup
            Its site and the sphere's density.
        """
        cost, pull = fit.against(responses)
        g, u = expected_gravity(setup.site, setup.tracer.density_kg_m3, setup.air.gas)
        off = fit.g_m_s2 - g
        by_input = np.array([fit.follow(one)[0] for one in responses])
        weight = 1.0 / (u**2 + fit.u_g_m_s2**2)
        value, expected = fit.misfit
        cost, pull = cost + weight * np.outer(by_input, by_input), pull + weight * off * by_input
        # back to what is stated, where the inputs' own squares count from
        value += weight * off**2 - 2.0 * float(pull @ at) + float(at @ cost @ at)
        return cls(value, expected, cost, pull - cost @ at, own, fit.g_m_s2 - float(by_input @ at), by_input, weight)

    @classmethod
    def of_paths(cls, fit: FittedPaths) -> SetupChiSquare:
        """Return that of flights fitted to paths, all else of them where it is least."""
        n, prior = fit.n_setup, fit.prior
        # without what is stated of the setup itself
        bare = prior.precision.copy()
        bare[:n, :n] -= np.diag(fit.unknowns.deviation**-2.0)
        matrix = fit.precision(SharedPrior(prior.mean, bare))
        across = matrix[:n, n:]
        cost = matrix[:n, :n] - across @ np.linalg.solve(matrix[n:, n:], across.T)
        at, own = fit.values[:n], fit.unknowns.deviation**-2.0
        # at the minimum the pull of the flights is that of what is stated
        pull = -own * at - cost @ at
        expected = fit.samples.change_m.size
        value = float(expected) - 2.0 * float(pull @ at) - float(at @ cost @ at)
        return cls(value, expected, cost, pull, own, fit.flights.g_m_s2, np.zeros(n), 0.0)

    def with_others(self, others: SetupLikelihood) -> SetupChiSquare:
        """Return chi-square with what other runs say of the inputs."""
        return replace(self, cost=self.cost + others.matrix, pull=self.pull - others.vector)

    def posterior(self, wrong: BoolArray, at: FloatArray) -> FloatArray:
        """Return the covariance of the inputs where flights are rigid and g is within what is known of it, (n, n).

        Each is within its own u. Where some, (n,), are wrong by more, and were held by it where the estimate has the
        inputs, `at`, what parts that from where they belong counts as uncertain as a whole.
        """
        own = self._freed(wrong)
        away = self.least(wrong)[0] - at if wrong.any() else np.zeros_like(at)
        matrix = self.cost + np.diag(own)
        # one input may be known 10^4 times as well as another: rounding parts both triangles by more than that leaves
        root = np.linalg.inv(np.linalg.cholesky(0.5 * (matrix + matrix.T)))
        return np.asarray(root.T @ root + np.outer(away, away))

    def without_g(self, expected_m_s2: float) -> SetupChiSquare:
        """Return chi-square of the flights alone, which know nothing of what g is expected to be."""
        off, by = self.g_m_s2 - expected_m_s2, self.by_input
        cost, pull = self.cost - self.weight * np.outer(by, by), self.pull - self.weight * off * by
        return replace(self, value=self.value - self.weight * off**2, cost=cost, pull=pull, weight=0.0)

    def gravity(self) -> float:
        """Return g of the flights with the inputs where chi-square is least."""
        return self.g_m_s2 + float(self.by_input @ self.least()[0])

    def least(self, freed: BoolArray | None = None) -> tuple[FloatArray, float]:
        """Return the deviations of least chi-square, and by how much they lessen it; some freed of their own u."""
        own = self.own if freed is None else self._freed(freed)
        off: FloatArray = np.asarray(-np.linalg.solve(self.cost + np.diag(own), self.pull))
        return off, float(-self.pull @ off)

    def _freed(self, which: BoolArray) -> FloatArray:
        return np.where(which, _FREE, self.own)

    def share_left(self, gain: float) -> float:
        """Return the share of what chi-square has beyond its mean that a gain leaves; 0 where noise makes the rest."""
        left = self.value - gain - self.expected
        return left / (left + gain) if self.sigmas_left(gain) > _NOISE else 0.0

    def sigmas_left(self, gain: float) -> float:
        """Return by how many of its standard deviations chi-square less a gain is above its mean."""
        return float((self.value - gain - self.expected) / np.sqrt(2.0 * self.expected))
