"""What recordings say of antennas, release and wavelength, with their covariance (method 4, Setup)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import UncertainInput
from radargui.model.setup import Setup, value_of

EXACT = 1e-3
"""Prior deviation of what the setup calls exact, in units of what a laboratory knows it to."""
_LEAST_LEARNT = 1e-3
"""Share of a variance that a recording takes away at the least, for a pull: rounding."""


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
    """

    inputs: tuple[UncertainInput, ...]
    deviation: FloatArray
    mean: FloatArray
    covariance: FloatArray

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
            pull = None if exact or learnt < _LEAST_LEARNT else by / math.sqrt(learnt)
            u_stated, u_found = (0.0, 0.0) if exact else (one.u, math.sqrt(variance) * one.u)
            out.append(SetupValue(one.key, stated, u_stated, stated + by * one.u, u_found, pull))
        return tuple(out)
