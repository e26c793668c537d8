"""What figures of a series draw, on paper and in the window: impacts with what describes them, and one parabola."""

import math
from collections.abc import Sequence

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.report.facts import ReportFacts
from radargui.report.run_facts import RunFacts
from radargui.restitution.speed_models import SpeedFit, preferred

_WORST_SHARE, _GOOD_SHARE = 0.1, 0.01
"""Of e: an e that is known to no better than the first is not drawn; the second decide how far the axis reaches."""
_MARGIN = 0.1
COVERED = 2.0
"""Standard uncertainties that a bar reaches to either side."""


def speed_points(runs: Sequence[RunFacts]) -> FloatArray:
    """Return speed before, e and its statistical u of the valid impacts, shape (3, n)."""
    found = [
        (impact.speed_before_m_s, impact.e, impact.u_e)
        for run in runs
        for impact in run.bounces.impacts
        if impact.valid and math.isfinite(impact.e) and impact.u_e < _WORST_SHARE * impact.e
    ]
    return np.array(found, np.float64).reshape(-1, 3).T


def shown_fits(facts: ReportFacts) -> list[SpeedFit]:
    """Return for each sample the model that the user chose, else the one that describes it best."""
    found = facts.findings
    fits = [
        sample.fit(found.model) if found.model else next(iter(preferred(sample.fits)), None) for sample in found.samples
    ]
    return [fit for fit in fits if fit is not None and fit.parameters]


def e_span(points: FloatArray) -> tuple[float, float]:
    """Return lowest and highest e drawn, for `speed_points` that are not empty: as far as the good ones reach."""
    known = points[:, points[2] < _GOOD_SHARE * points[1]]
    _, e, u = known if known.size else points
    low, high = float((e - COVERED * u).min()), float((e + COVERED * u).max())
    room = _MARGIN * (high - low) or 0.5 * abs(high) or 1.0
    return low - room, high + room


def mean_gravity(runs: Sequence[RunFacts]) -> float:
    """Return the mean of g over the runs whose fall is drawn, in m/s^2; of one parabola for all."""
    g = [run.bounces.free_fall.g_m_s2 for run in runs if run.falls is not None and run.bounces.free_fall is not None]
    return sum(g) / len(g)
