"""Chi-square of flights, g and the setup's own values where those are off, as a quadratic form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.estimation.readout.input_response import InputResponse
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.gravity import EARTH_GRAVITY_M_S2, gravity_of_site, share_in_air
from radargui.model.setup import Setup
from radargui.restitution.flight_fit import FlightFit

_EARTH_M_S2, _U_EARTH_M_S2 = float(np.mean(EARTH_GRAVITY_M_S2)), float(np.ptp(EARTH_GRAVITY_M_S2)) / np.sqrt(12.0)
"""g where the setup names no site: that of every place, evenly spread."""
_FREE, _HELD = 1e-6, 1e6
"""Weights of the square of an input that is freed (what nothing shows stays where it is), and of an exact one."""

_MISTAKE = 20.0
"""Deviation of a misstated value in what a laboratory knows it to: 10 degrees, some centimetres."""
_NOISE = 2.0
"""Deviations that chi-square may be above its mean by chance."""
_NOT_LINEAR = 6e-4
"""What the linear answer misses of the bends that inputs off by their u make, per degree of freedom: 2.5 % squared. In
45 dB angles known to 0.5 degrees bend flights by hundreds of deviations, and what that misses looked like azimuths tens
of degrees off (decision 51)."""


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
    blur
        By what a gain is to be divided, since inputs that are off by their u bend flights in no linear way; 1 or more.
    """

    value: float
    expected: int
    cost: FloatArray
    pull: FloatArray
    own: FloatArray
    blur: float = 1.0

    @classmethod
    def of(
        cls, fit: FlightFit, keys: Sequence[str], responses: Sequence[InputResponse], setup: Setup, exact: BoolArray
    ) -> SetupChiSquare:
        """Return that of fitted flights.

        Parameters
        ----------
        fit
            Of the flights.
        keys, responses
            Of the inputs; a key that stands several times is one of several things, of which one is true.
        setup
            Its site and the sphere's density.
        exact
            Which inputs are called exact, shape (n,).
        """
        cost, pull = fit.against(responses)
        site = gravity_of_site(setup.site)
        g, u = (_EARTH_M_S2, _U_EARTH_M_S2) if site is None else site[:2]
        off = fit.g_m_s2 - share_in_air(setup.tracer.density_kg_m3) * g
        by_input = np.array([fit.follow(one)[0] for one in responses])
        weight = 1.0 / (u**2 + fit.u_g_m_s2**2)
        own = np.where(exact, _HELD, [float(keys.count(key)) for key in keys])
        value, expected = fit.misfit
        cost, pull = cost + weight * np.outer(by_input, by_input), pull + weight * off * by_input
        # an exact input is not off
        blur = max(1.0, _NOT_LINEAR * float(np.diag(cost)[~exact].sum()))
        return cls(value + weight * off**2, expected, cost, pull, own, blur)

    def least(self, freed: BoolArray | None = None) -> tuple[FloatArray, float]:
        """Return the deviations of least chi-square, and by how much they lessen it; some freed of their own u."""
        own = self.own if freed is None else np.where(freed, _FREE, self.own)
        off: FloatArray = np.asarray(-np.linalg.solve(self.cost + np.diag(own), self.pull))
        return off, float(-self.pull @ off)

    def share_left(self, gain: float) -> float:
        """Return the share of what chi-square has beyond its mean that a gain leaves; 0 where noise makes the rest."""
        left = self.value - gain - self.expected
        return left / (left + gain) if self.sigmas_left(gain) > _NOISE else 0.0

    def sigmas_left(self, gain: float) -> float:
        """Return by how many of its standard deviations chi-square less a gain is above its mean."""
        return float((self.value - gain - self.expected) / np.sqrt(2.0 * self.expected))

    def misstated(self, which: BoolArray) -> tuple[FloatArray, float]:
        """Return the mean squares of how far off the inputs are where some are misstated, and ln E of that.

        Against the setup as it is; by `_MISTAKE` of what a laboratory knows them to, standard deviation. Of Gaussians:
        2 ln E = pull (cost + own)^-1 pull + ln det own - ln det (cost + own), mean off and covariance (cost + own)^-1.
        """
        square, there = self._posterior(np.where(which, _MISTAKE**-2.0, self.own))
        return square, there - self._posterior(self.own)[1]

    def _posterior(self, own: FloatArray) -> tuple[FloatArray, float]:
        normal = self.cost + np.diag(own)
        covariance = np.linalg.inv(normal)
        off = -covariance @ self.pull
        evidence = 0.5 * (np.log(own).sum() - np.linalg.slogdet(normal)[1] - self.pull @ off)
        return np.asarray(off**2 + np.diag(covariance)), float(evidence)
