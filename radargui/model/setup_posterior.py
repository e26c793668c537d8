"""What a recording says of antennas, release and wavelength: likelihood and posterior with covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, OF_SPHERE, TILT, UncertainInput, uncertain_inputs, usual_u
from radargui.model.setup import Setup, value_of

EXACT = 1e-3
"""Prior deviation of what the setup calls exact, in units of what a laboratory knows it to."""
_MIN_LEARNT = 1e-3
"""Share of a variance that a recording takes away at the least, for a pull: rounding."""


def unknown_inputs(setup: Setup) -> tuple[tuple[UncertainInput, ...], FloatArray]:
    """Return the setup's unknowns - antennas, release, wavelength - and the deviations of their priors, shape (n,).

    Inputs that move no path are left out. A value that the setup calls exact gets the u to which a laboratory knows it,
    and a prior of nearly zero deviation.
    """
    stated = [
        one
        for one in uncertain_inputs(setup)
        if one.key not in (TILT, CLOCK, *OF_SPHERE) and not one.key.endswith("polarization_deg")
    ]
    stated = [one for one in stated if one.u > 0.0 or usual_u(one) > 0.0]
    deviation = np.array([1.0 if one.u > 0.0 else EXACT for one in stated])
    return tuple(one if one.u > 0.0 else replace(one, u=usual_u(one)) for one in stated), deviation


@dataclass(frozen=True, eq=False)
class SetupLikelihood:
    """What a recording says of the setup's unknowns a, without their prior: -ln L = a^T matrix a / 2 - vector.a.

    Attributes
    ----------
    matrix, vector
        Shapes (n, n) and (n,), a in standard uncertainties from what is stated (`unknown_inputs`).
    """

    matrix: FloatArray
    vector: FloatArray

    @staticmethod
    def sound(matrix: FloatArray, vector: FloatArray) -> SetupLikelihood:
        """Return a likelihood without what rounding has made negative of its matrix."""
        values, directions = np.linalg.eigh(0.5 * (matrix + matrix.T))
        return SetupLikelihood((directions * np.maximum(values, 0.0)) @ directions.T, vector)

    @staticmethod
    def of_posterior(off: FloatArray, covariance: FloatArray, deviation: FloatArray, n: int) -> SetupLikelihood:
        """Return the likelihood of the first n unknowns of a posterior; others are integrated out.

        Parameters
        ----------
        off, covariance
            Posterior mean less that of the prior, shape (m,), and covariance, shape (m, m).
        deviation
            Of the independent priors, which are taken off, shape (m,).
        """
        # of correlations: units have no common size
        u = np.sqrt(np.diag(covariance))
        precision = np.linalg.inv(covariance / np.outer(u, u)) / np.outer(u, u)
        vector = precision @ off
        precision = precision - np.diag(deviation**-2.0)
        mixed, rest = precision[:n, n:], np.linalg.pinv(precision[n:, n:], hermitian=True)
        matrix = precision[:n, :n] - mixed @ rest @ mixed.T
        return SetupLikelihood.sound(matrix, vector[:n] - mixed @ rest @ vector[n:])

    def widened(self, factor: float) -> SetupLikelihood:
        """Return it with all uncertainties times a factor."""
        return SetupLikelihood(self.matrix / factor**2, self.vector / factor**2)

    def smeared(self, spread: FloatArray) -> SetupLikelihood:
        """Return the likelihood of what this run's unknowns scatter about by N(0, spread spread^T), spread (n, k)."""
        across = self.matrix @ spread
        gain = across @ np.linalg.inv(np.eye(spread.shape[1]) + spread.T @ across)
        return SetupLikelihood.sound(self.matrix - gain @ across.T, self.vector - gain @ (spread.T @ self.vector))

    def misfit(self, at: FloatArray) -> tuple[float, int]:
        """Return chi-square of unknowns, (n,), and of how many directions: those known better than what is stated."""
        values, directions = np.linalg.eigh(self.matrix)
        known = values > 1.0
        off = directions[:, known].T @ (self.vector - self.matrix @ at)
        return float((off**2 / values[known]).sum()), int(known.sum())


@dataclass(frozen=True, slots=True)
class SetupValue:
    """One value of the setup as it was stated and as recordings have it.

    Attributes
    ----------
    key
        As in `model.assumed`: receiver[2].tilt_deg; a direction of a calibration's covariance has its number.
    stated, u_stated, found, u_found
        In the value's unit; a direction in its standard uncertainty, from zero.
    pull
        (found - stated) / sqrt(u_stated^2 - u_found^2): normal with deviation one where what is stated is right. None
        of what the setup calls exact, or where nothing was learnt.
    """

    key: str
    stated: float
    u_stated: float
    found: float
    u_found: float
    pull: float | None


@dataclass(frozen=True, eq=False)
class SetupPosterior:
    """What a recording says of the setup's unknowns, in standard uncertainties from what was stated.

    Attributes
    ----------
    inputs, deviation
        What they are, and the deviations of their priors, shape (n,).
    mean, covariance
        Shapes (n,) and (n, n); before the recording zero and diag(deviation^2).
    alone
        What the recording says by itself.
    others
        What other runs say besides; None where nothing of it is in mean and covariance.
    """

    inputs: tuple[UncertainInput, ...]
    deviation: FloatArray
    mean: FloatArray
    covariance: FloatArray
    alone: SetupLikelihood
    others: SetupLikelihood | None = None

    def with_others(self, others: SetupLikelihood) -> SetupPosterior:
        """Return it with what other runs say."""
        precision = np.linalg.inv(self.covariance)
        covariance = np.asarray(np.linalg.inv(precision + others.matrix))
        mean = covariance @ (precision @ self.mean + others.vector)
        return replace(self, mean=mean, covariance=covariance, others=others)

    def applied(self, setup: Setup) -> Setup:
        """Return a setup with the values that were found, unchecked."""
        for one, by in zip(self.inputs, self.mean.tolist(), strict=True):
            setup = one.moved(setup, by)
        return setup

    def values(self, setup: Setup) -> tuple[SetupValue, ...]:
        """Return each value as a setup states it, and as it was found."""
        out = []
        for one, deviation, by, variance in zip(
            self.inputs, self.deviation.tolist(), self.mean.tolist(), np.diag(self.covariance).tolist(), strict=True
        ):
            exact, learnt = deviation < 1.0, deviation**2 - variance
            stated = 0.0 if one.together else value_of(setup, one.key)
            pull = None if exact or learnt < _MIN_LEARNT else by / math.sqrt(learnt)
            u_stated, u_found = (0.0, 0.0) if exact else (one.u, math.sqrt(variance) * one.u)
            out.append(SetupValue(one.key, stated, u_stated, stated + by * one.u, u_found, pull))
        return tuple(out)
