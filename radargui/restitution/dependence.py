"""What e depends on besides the speed, angle of incidence, diameter, number of the drop; and e_t on the angle."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.rounding import plain, quantity
from radargui.restitution.speed_models import FEWEST_RUNS, ImpactPoint, SpeedFit, jackknife, title_of
from radargui.restitution.statistics import CONFIDENCE, probability, student


@dataclass(frozen=True, slots=True)
class Covariate:
    """What a value of impacts may depend on.

    Attributes
    ----------
    title, unit, scale
        For people: name, unit shown, and how much of it one of its own is.
    attribute, of
        Names of it and of the value in an `ImpactPoint`.
    """

    title: str
    unit: str
    attribute: str
    scale: float = 1.0
    of: str = "e"

    @property
    def name(self) -> str:
        """What it is called among the others: of e, what e depends on."""
        return self.title if self.of == "e" else f"{self.title}, {self.of}"

    @property
    def label(self) -> str:
        """Name and unit of an axis."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


COVARIATES = {
    "angle_deg": Covariate("angle of incidence", "°", "angle_deg"),
    "diameter_m": Covariate("diameter", "mm", "diameter_m", 1e3),
    "drop": Covariate("number of the drop", "", "drop"),
    "e_t": Covariate("angle of incidence", "°", "angle_deg", of="e_t"),
}


@dataclass(frozen=True, slots=True)
class Dependence:
    """The slope of e along something, with e of all impacts brought to one speed.

    Attributes
    ----------
    on
        What it is, among `COVARIATES`.
    impacts
        Those that tell it.
    e
        Of these, brought to one speed; e_t as measured; shape (n,).
    n_groups
        How many runs they belong to; of the diameter how many spheres.
    reduced
        How they were brought there; empty where they are as measured.
    at, e_at
        Mean of what e may depend on, and e there.
    slope, u_slope, interval_low, interval_high
        de over it, per its unit; standard uncertainty with the runs (of the diameter the spheres) left out one at a
        time, 95 % by Student's t. None where `problem` says why.
    p
        How often chance gives such a slope or more.
    """

    on: str
    impacts: tuple[ImpactPoint, ...]
    e: tuple[float, ...]
    n_groups: int
    reduced: str = ""
    at: float | None = None
    e_at: float | None = None
    slope: float | None = None
    u_slope: float | None = None
    interval_low: float | None = None
    interval_high: float | None = None
    p: float | None = None
    problem: str = ""

    @property
    def x(self) -> FloatArray:
        """What e may depend on, of each impact, in its unit, shape (n,)."""
        return _column(self.impacts, COVARIATES[self.on].attribute)

    @property
    def u(self) -> FloatArray:
        """Standard uncertainty of e or e_t of each impact, shape (n,)."""
        return _column(self.impacts, f"u_{COVARIATES[self.on].of}")

    def line(self, x: FloatArray) -> FloatArray:
        """Return e on the line at x, shape (n,)."""
        return np.asarray((self.e_at or 0.0) + (self.slope or 0.0) * (x - (self.at or 0.0)))

    @property
    def words(self) -> str:
        """What was found, or why nothing was."""
        covariate = COVARIATES[self.on]
        if self.problem:
            return f"{covariate.of} against the {covariate.title}: {self.problem}"
        unit = f"/{covariate.unit}" if covariate.unit else " a drop"
        slope = quantity(self.slope, self.u_slope, "", 1.0 / covariate.scale)
        p = self.p or 0.0
        said = "depends on it" if p < 1.0 - CONFIDENCE else "no dependence beyond chance"
        brought = f", {self.reduced}" if self.reduced else ""
        return f"{covariate.of} against the {covariate.title}: slope {slope}{unit}, p {probability(p)}: {said}{brought}"


def dependences(points: Sequence[ImpactPoint], fit: SpeedFit | None) -> tuple[Dependence, ...]:
    """Return the slopes of e along all `COVARIATES`.

    e of an impact is multiplied by what a law of the speed gives at the mean speed over what it gives at its own: the
    later impacts of a run are slower, and often steeper or flatter too.

    Parameters
    ----------
    points
        Valid impacts of drops that count, each once.
    fit
        That describes them best; None: they are left as measured.
    """
    return tuple(_dependence(points, name, fit) for name in COVARIATES)


def _dependence(points: Sequence[ImpactPoint], on: str, fit: SpeedFit | None) -> Dependence:
    covariate = COVARIATES[on]
    names = (covariate.attribute, covariate.of)
    known = tuple(one for one in points if all(math.isfinite(getattr(one, name)) for name in names))
    x, e, u = (_column(known, name) for name in (*names, f"u_{covariate.of}"))
    # all drops of a sphere have its diameter: they tell it once
    of = x if on == "diameter_m" else np.array([one.run for one in known])
    groups = np.unique(of)
    reduced, scatter = "", float(e.std()) if e.size else 0.0
    if fit is not None and fit.parameters and known and covariate.of == "e":
        speed = _column(known, "speed_m_s")
        at = float(speed.mean())
        scatter = fit.scatter or 0.0
        if fit.model != "constant":
            expected, _ = fit.e(np.append(speed, at))
            e = e * expected[-1] / expected[:-1]
            reduced = f"at {plain(at, 3, 'm/s')} (brought there by the {title_of(fit.model)})"
    found = Dependence(on, known, tuple(e.tolist()), int(groups.size), reduced)
    title = covariate.title
    if not known:
        return _without(found, f"no impact tells its {covariate.name}")
    if float(np.ptp(x)) <= 1e-9 * float(np.abs(x).max()):
        return _without(found, f"all impacts have one {title}")
    if groups.size < FEWEST_RUNS:
        return _without(found, f"{FEWEST_RUNS} {'diameters' if on == 'diameter_m' else 'runs'} are needed")
    weights = 1.0 / (u**2 + scatter**2)
    middle = float(np.average(x, weights=weights))
    lines = [_line(x[kept] - middle, e[kept], weights[kept]) for kept in (of != one for one in groups)]
    if not np.isfinite(lines).all():
        return _without(found, f"without one run all impacts have one {title}")
    from scipy.special import stdtr

    e_at, slope = _line(x - middle, e, weights)
    u_slope = math.sqrt(jackknife(np.array(lines))[1, 1])
    dof, half = groups.size - 1, student(groups.size - 1) * u_slope
    return Dependence(
        on,
        known,
        tuple(e.tolist()),
        int(groups.size),
        reduced,
        middle,
        e_at,
        slope,
        u_slope,
        slope - half,
        slope + half,
        float(2.0 * stdtr(dof, -abs(slope) / u_slope)) if u_slope else float(slope == 0.0),
    )


def _column(points: Sequence[ImpactPoint], name: str) -> FloatArray:
    """Return an attribute of each impact, shape (n,)."""
    return np.array([getattr(one, name) for one in points], dtype=np.float64)


def _without(found: Dependence, problem: str) -> Dependence:
    return Dependence(found.on, found.impacts, found.e, found.n_groups, found.reduced, problem=problem)


def _line(x: FloatArray, e: FloatArray, weights: FloatArray) -> tuple[float, float]:
    """Return e at x = 0 and the slope of the weighted line; not a number where all x are one."""
    away = x - float(np.average(x, weights=weights))
    square = float(weights @ away**2)
    if square <= 1e-18 * float(weights @ x**2):
        return math.nan, math.nan
    slope = float(weights @ (away * e)) / square
    return float(np.average(e, weights=weights)) - slope * float(np.average(x, weights=weights)), slope
