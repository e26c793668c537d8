"""Flights under rival solutions: what the evidence does not rule out belongs to the uncertainty of g and e."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.correction.joint.choose import Chosen
from radargui.model.arrays import FloatArray
from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.flight_plan import fit_free_flights

_MOST_RIVALS = 3
_WIDENED = 1.2


def fit_with_rivals(chosen: Chosen, normal: FloatArray, onset_s: float) -> FlightFit | None:
    """Fit the free flights; rivals with the same impacts widen the covariance.

    V = c^2 sum w (V_k + d_k d_k^T) / sum w, d_k the difference of solution k from the chosen one; the heaviest three
    rivals are fitted. c = 1.2: what the maps cannot follow; of 164 simulated falls 92 % had g within 2u without it,
    97 % with it.

    Parameters
    ----------
    chosen
        The joint solution and its rivals.
    normal, onset_s
        As for `fit_free_flights`.
    """
    fit = fit_free_flights(chosen.solution, normal, onset_s)
    if fit is None:
        return None
    total, covariance, here = 1.0, fit.covariance.copy(), _values(fit)
    for solution, weight in sorted(chosen.rivals, key=lambda rival: -rival[1])[:_MOST_RIVALS]:
        other = fit_free_flights(solution, normal, onset_s)
        if other is not None and other.covariance.shape == covariance.shape:
            away = _values(other) - here
            covariance += weight * (other.covariance + np.outer(away, away))
            total += weight
    return replace(fit, covariance=_WIDENED**2 * covariance / total)


def _values(fit: FlightFit) -> FloatArray:
    """Return what the covariance is of."""
    per_impact = np.column_stack([fit.impact_s, fit.before_m_s, fit.after_m_s])
    return np.concatenate([[fit.g_m_s2, fit.drag_1_m], per_impact.ravel()])
