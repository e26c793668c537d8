"""How e depends on the impact speed: four laws and those of plug-ins, each fitted with its uncertainty and tested."""

import logging
import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import RadarGuiError
from radargui.model.plugins import load_plugin, plugins
from radargui.model.rounding import quantity
from radargui.restitution.statistics import CONFIDENCE, freedom, probability, student

_logger = logging.getLogger(__name__)
ModelName = str
"""Of a law in `MODELS`, or of a plug-in of the group `radargui.laws`, which is a `SpeedModel`."""


@dataclass(frozen=True, slots=True)
class SpeedModel:
    """One dependence of e on v, the speed in m/s.

    Attributes
    ----------
    title, equation, source
        For people; where it comes from.
    parameters
        Names and units.
    e
        e of speeds, shape (n,), for values of the parameters.
    start
        Values to begin with for a mean e; all stay below 30 in size, or the fit counts as diverging.
    """

    title: str
    equation: str
    source: str
    parameters: tuple[tuple[str, str], ...]
    e: Callable[..., FloatArray]
    start: Callable[[float], tuple[float, ...]]


_SERIES = (1.0, -1.15344, 0.79826, -0.48358, 0.28528)  # in x = a v^(1/5), after Ramírez et al. 1999 (`MODELS`)
_LARGEST = 0.6
"""Of a v^(1/5), e = 0.53: by the ratio of the coefficients the first term left out reaches 0.01 of e there."""


def _viscoelastic(v: FloatArray, a: float) -> FloatArray:
    return np.asarray(np.polynomial.polynomial.polyval(a * v**0.2, _SERIES))


MODELS: dict[ModelName, SpeedModel] = {
    "constant": SpeedModel("constant", "e = e0", "", (("e0", ""),), lambda v, e0: np.full_like(v, e0), lambda e: (e,)),
    "power": SpeedModel(
        "power law",
        "e = e1 (v / (1 m/s))^-n",
        "",
        (("e1", ""), ("n", "")),
        lambda v, e1, n: np.asarray(e1 * v**-n),
        lambda e: (e, 0.0),
    ),
    "johnson": SpeedModel(
        "Johnson, fully plastic",
        "e = e1 (v / (1 m/s))^-1/4",
        "Johnson, Contact Mechanics, 1985, eq. 11.47",
        (("e1", ""),),
        lambda v, e1: np.asarray(e1 * v**-0.25),
        lambda e: (e,),
    ),
    "viscoelastic": SpeedModel(
        "viscoelastic spheres",
        "e = 1 - 1.15344 x + 0.79826 x^2 - 0.48358 x^3 + 0.28528 x^4, x = a v^1/5",
        "Schwager & Pöschel, Phys. Rev. E 57, 650, 1998; Ramírez et al., Phys. Rev. E 60, 4465, 1999",
        (("a", "(s/m)^1/5"),),
        _viscoelastic,
        lambda e: (max(1.0 - e, 0.01),),
    ),
}
"""By name; the sources stand in them."""


def model_names() -> tuple[ModelName, ...]:
    """Return the names of all laws: the program's own, then those of plug-ins."""
    return (*MODELS, *(name for name in plugins("laws") if name not in MODELS))


def speed_model(name: ModelName) -> SpeedModel:
    """Return a law.

    Raises
    ------
    RadarGuiError
        There is none of this name, or the plug-in cannot be loaded.
    """
    if name in MODELS:
        return MODELS[name]
    found = load_plugin("laws", name)
    if not isinstance(found, SpeedModel):
        raise RadarGuiError(f"The plug-in {name} is no SpeedModel", remedy="See docs/plugins.md.")
    return found


def title_of(name: ModelName) -> str:
    """Return what a law is called; one that cannot be loaded by its name."""
    try:
        return speed_model(name).title
    except RadarGuiError:
        return name


@dataclass(frozen=True, slots=True)
class ImpactPoint:
    """One impact: the run it belongs to, speed before it, e, its statistical and combined u (None: not known).

    Beside it what e may depend on too: angle of incidence from the normal, diameter of the sphere, number of the drop
    in its session; and e_t with its u. NaN where that is not known.
    """

    run: str
    speed_m_s: float
    e: float
    u_e: float
    u_e_combined: float | None = None
    angle_deg: float = math.nan
    diameter_m: float = math.nan
    drop: float = math.nan
    e_t: float = math.nan
    u_e_t: float = math.nan


@dataclass(frozen=True, slots=True)
class Parameter:
    """A value found, in its unit.

    Attributes
    ----------
    u, interval_low, interval_high
        Standard uncertainty from the scatter, and 95 % by Student's t: what compares with another fit on one setup.
    u_combined
        With what all impacts share (calibration, sphere); None where they do not say it.
    """

    name: str
    unit: str
    value: float
    u: float
    interval_low: float
    interval_high: float
    u_combined: float | None

    @property
    def words(self) -> str:
        """Name, value and standard uncertainty."""
        return f"{self.name} = {quantity(self.value, self.u_combined or self.u, self.unit)}"


@dataclass(frozen=True, slots=True)
class SpeedFit:
    """One model fitted to the impacts of several runs.

    Attributes
    ----------
    model
        Name of the law.
    n_impacts, n_runs, speed_low_m_s, speed_high_m_s
        What it was fitted to.
    parameters
        Empty where `problem` says why there are none.
    covariance
        Of the parameters, from the scatter.
    chi2, degrees_of_freedom, p
        Test of fit: the stated statistical uncertainties alone, and how often chance gives as much or more.
    birge_ratio
        sqrt(chi2 / degrees of freedom).
    trend_p
        Test of the shape, which allows for any scatter: how often the residuals of a model that is right depend on ln v
        as much or more, by a slope (models with one parameter) or a curvature (with two). None of fewer than three
        runs.
    scatter
        Standard deviation of e beyond the stated uncertainties, which the weights take into account (maximum
        likelihood); 0 where there is none.
    aicc
        Akaike's criterion for small samples: the smaller, the better; only differences between models of the same
        impacts count.
    u_from
        How the uncertainties were found.
    u_e, factor
        Median of the stated statistical u, and Student's factor of 95 %, see `prediction`.
    """

    model: ModelName
    n_impacts: int
    n_runs: int
    speed_low_m_s: float = math.nan
    speed_high_m_s: float = math.nan
    parameters: tuple[Parameter, ...] = ()
    covariance: tuple[tuple[float, ...], ...] = ()
    chi2: float | None = None
    degrees_of_freedom: int | None = None
    p: float | None = None
    birge_ratio: float | None = None
    trend_p: float | None = None
    scatter: float | None = None
    aicc: float | None = None
    u_from: str = ""
    u_e: float | None = None
    factor: float | None = None
    problem: str = ""

    def e(self, speed_m_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return e of the model and its standard uncertainty (scatter), each shape (n,), at speeds (n,)."""
        model, at = speed_model(self.model), np.array([one.value for one in self.parameters])
        slopes = _slopes(model, speed_m_s, at)
        variance = np.einsum("np,pq,nq->n", slopes, np.array(self.covariance), slopes)
        return model.e(speed_m_s, *at), np.sqrt(variance)

    def prediction(self, speed_m_s: FloatArray) -> FloatArray:
        """Return half of the interval that holds e of one more impact, measured like these, with 95 %, shape (n,)."""
        _, u = self.e(speed_m_s)
        return np.asarray((self.factor or 0.0) * np.sqrt(u**2 + (self.scatter or 0.0) ** 2 + (self.u_e or 0.0) ** 2))

    @property
    def words(self) -> str:
        """What was found, or why nothing was."""
        title = title_of(self.model)
        if self.problem:
            return f"{title}: {self.problem}"
        found = ", ".join(one.words for one in self.parameters)
        shape = "" if self.trend_p is None else f"; left dependence on the speed: p {probability(self.trend_p)}"
        return (
            f"{title}: {found} (χ² = {self.chi2:.3g} of {freedom(self.degrees_of_freedom or 0)}, "
            f"p {probability(self.p or 0.0)}{shape})"
        )

    @property
    def describes(self) -> bool | None:
        """Whether e depends on the speed as the model says, at 5 %; None where that cannot be tested."""
        return None if self.trend_p is None else self.trend_p >= 1.0 - CONFIDENCE


def fit_speed_models(points: Sequence[ImpactPoint]) -> tuple[SpeedFit, ...]:
    """Return every law fitted to the same impacts, in the order of `model_names`.

    Parameters
    ----------
    points
        Valid impacts of drops that count, each once.
    """
    return tuple(fit_speed_model(points, name) for name in model_names())


def preferred(fits: Sequence[SpeedFit]) -> tuple[SpeedFit, ...]:
    """Return the fits within 2 of the smallest AICc, the best first: between these the impacts do not decide.

    Burnham & Anderson, Model Selection and Multimodel Inference, 2002, 2.6. It chooses nothing for the user.
    """
    known = sorted((fit for fit in fits if fit.aicc is not None), key=lambda fit: fit.aicc or 0.0)
    return tuple(fit for fit in known if (fit.aicc or 0.0) - (known[0].aicc or 0.0) <= 2.0)


_TOO_SMALL = f"e is too small for the series (a v^1/5 above {_LARGEST:g}, e below 0.53)"
FEWEST_RUNS = 3  # u is the scatter between runs, which two would tell by one difference only
_MAX_BIAS = 0.25
"""Of the slope from errors of the speed, in its standard uncertainties."""
_STEP, _CLOSE, _MAX_STEPS, _LARGEST_PARAMETER = 1e-6, 1e-10, 50, 30.0
"""Of central differences (rounding: 1e-10); converged; by hand, steps and parameters that tell that it diverges."""


def fit_speed_model(points: Sequence[ImpactPoint], name: ModelName) -> SpeedFit:
    """Return one model fitted to e of impacts.

    Weights are 1 / (u^2 + scatter^2), the scatter by maximum likelihood. Impacts of one run share what differs from
    run to run, and those that follow each other share a flight: the covariance is that of the runs left out one at a
    time (jackknife; Efron & Stein 1981), its interval Student's with one degree of freedom fewer than runs. Of one or
    two runs it is that of least squares.

    e is v' / v: an error of ln v goes into ln e with the opposite sign, so `u_e` holds it already. It bends the slope
    by less than a quarter of its uncertainty, or the slope is refused: the speeds hardly differ then.

    Parameters
    ----------
    points
        Of all runs.
    name
        Which law; one of a plug-in that fails says so instead of a result.
    """
    if name in MODELS:
        return _fitted(points, name, MODELS[name])
    try:
        return _fitted(points, name, speed_model(name))
    except Exception as error:
        # a plug-in must not cost the report
        _logger.exception("The law %s was left out", name)
        said = (
            str(error) if isinstance(error, RadarGuiError) else f"the plug-in failed: {type(error).__name__}: {error}"
        )
        return SpeedFit(name, len(points), len({point.run for point in points}), problem=said.strip().rstrip(":"))


def _fitted(points: Sequence[ImpactPoint], name: ModelName, model: SpeedModel) -> SpeedFit:
    runs = Counter(point.run for point in points)
    n, p = len(points), len(model.parameters)
    fit = SpeedFit(name, n, len(runs))
    if n < p + 2:
        return replace(fit, problem=f"{p + 2} valid impacts are needed, there are {n}")
    v, e, u = np.array([(point.speed_m_s, point.e, point.u_e) for point in points]).T
    fit = replace(fit, speed_low_m_s=float(v.min()), speed_high_m_s=float(v.max()))
    try:
        scatter = _scatter(model, v, e, u)
        variance = u**2 + scatter**2
        at = _least_squares(model, v, e, variance, model.start(float(e.mean())))
        slopes = _slopes(model, v, at)
        inverse = np.linalg.inv((slopes.T / variance) @ slopes)
        if p > 1 and float(np.sum(u**2 / variance)) > _MAX_BIAS * _spread(v, e, variance) ** 0.5:
            return replace(fit, problem="the speeds differ too little for a slope: drop from other heights too")
        if len(runs) >= FEWEST_RUNS:
            of = np.array([point.run for point in points])
            # with the weights of all: one run less must not change what the others are worth
            left = np.array([_least_squares(model, v[k], e[k], variance[k], at) for k in (of != run for run in runs)])
            covariance = jackknife(left)
            factor, u_from = student(len(runs) - 1), "from the runs, left out one at a time"
        else:
            # maximum likelihood knows no degrees of freedom
            covariance = inverse * n / (n - p)
            factor, u_from = student(n - p), "from least squares, for there are too few runs"
    except np.linalg.LinAlgError:
        # the series has a lowest e, below which there is none
        return replace(fit, problem=_TOO_SMALL if name == "viscoelastic" else "it cannot be fitted to these impacts")
    if name == "viscoelastic" and at[0] * float(v.max()) ** 0.2 > _LARGEST:
        return replace(fit, problem=_TOO_SMALL)
    own = np.sqrt(np.diag(covariance))
    shared = _shared(points, inverse @ (slopes.T / variance))
    residual = e - model.e(v, *at)
    chi2 = float(np.sum((residual / u) ** 2))
    # the scatter is a parameter too
    k = p + 1
    from scipy.special import chdtrc

    combined = own if shared is None else np.hypot(own, shared)
    found = zip(model.parameters, at.tolist(), own.tolist(), combined.tolist(), strict=True)
    return replace(
        fit,
        parameters=tuple(
            Parameter(key, unit, x, sd, x - factor * sd, x + factor * sd, None if shared is None else both)
            for (key, unit), x, sd, both in found
        ),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        chi2=chi2,
        degrees_of_freedom=n - p,
        p=float(chdtrc(n - p, chi2)),
        birge_ratio=math.sqrt(chi2 / (n - p)),
        trend_p=_trend_p(points, residual, variance, slopes, e - residual),
        scatter=scatter,
        # Hurvich & Tsai 1989
        aicc=_minus_2_log_likelihood(residual, variance) + 2.0 * k * n / (n - k - 1) if n > k + 1 else None,
        u_from=u_from,
        u_e=float(np.median(u)),
        factor=factor,
    )


def jackknife(left: FloatArray) -> FloatArray:
    """Return the covariance (p, p) of values found with each run left out in turn, shape (n_runs, p)."""
    spread = left - left.mean(axis=0)
    # n - 1 of n runs differ by little: the jackknife multiplies their scatter by it (Efron & Stein 1981)
    return np.asarray((len(left) - 1.0) / len(left) * spread.T @ spread)


def _trend_p(
    points: Sequence[ImpactPoint], residual: FloatArray, variance: FloatArray, slopes: FloatArray, e: FloatArray
) -> float | None:
    """Return the p-value of what the residuals still depend on, see `SpeedFit.trend_p` (after Ramsey 1969)."""
    of, x = np.array([point.run for point in points]), np.log([point.speed_m_s for point in points])
    runs = dict.fromkeys(of.tolist())
    if len(runs) < FEWEST_RUNS:
        return None
    # the fit has taken the mean, of two parameters the slope too
    more = e * (x - x.mean()) ** slopes.shape[1]
    design = np.column_stack([slopes, more]) / np.sqrt(variance)[:, None]
    wanted = residual / np.sqrt(variance)

    def found(kept: BoolArray) -> float:
        return float(np.linalg.lstsq(design[kept], wanted[kept], rcond=None)[0][-1])

    from scipy.special import stdtr

    u = math.sqrt(jackknife(np.array([[found(of != run)] for run in runs]))[0, 0])
    return float(2.0 * stdtr(len(runs) - 1, -abs(found(np.ones(of.size, dtype=np.bool_))) / u)) if u else None


def _least_squares(
    model: SpeedModel, v: FloatArray, e: FloatArray, variance: FloatArray, start: Sequence[float] | FloatArray
) -> FloatArray:
    """Return the parameters, shape (p,), by Gauss and Newton: the models are nearly linear in them."""
    at, weights = np.array(start, dtype=np.float64), variance**-0.5
    for _ in range(_MAX_STEPS):
        residual = (e - model.e(v, *at)) * weights
        step = np.linalg.lstsq(_slopes(model, v, at) * weights[:, None], residual, rcond=None)[0]
        at += step
        # it diverges
        if not (np.abs(at) < _LARGEST_PARAMETER).all():
            break
        if (np.abs(step) <= _CLOSE * (1.0 + np.abs(at))).all():
            return at
    raise np.linalg.LinAlgError


def _slopes(model: SpeedModel, v: FloatArray, at: FloatArray) -> FloatArray:
    """Return d e / d parameter, shape (n, p)."""
    steps = _STEP * np.eye(at.size)
    return np.stack([(model.e(v, *(at + h)) - model.e(v, *(at - h))) / (2.0 * _STEP) for h in steps], axis=1)


def _scatter(model: SpeedModel, v: FloatArray, e: FloatArray, u: FloatArray) -> float:
    """Return the standard deviation beyond u that makes the residuals likeliest."""
    from scipy.optimize import minimize_scalar

    start = model.start(float(e.mean()))

    def cost(scatter: float) -> float:
        variance = u**2 + scatter**2
        return _minus_2_log_likelihood(e - model.e(v, *_least_squares(model, v, e, variance, start)), variance)

    # a model far from these impacts (Johnson's law of an e that hardly changes) leaves more than they differ by
    left = e - model.e(v, *_least_squares(model, v, e, np.ones_like(e), start))
    # no more than what would be left if the stated uncertainties were nothing
    largest = max(float(e.std()), float(np.sqrt(np.mean(left**2)))) or float(u.max())
    found = float(minimize_scalar(cost, bounds=(0.0, largest), method="bounded").x)
    return found if cost(found) < cost(0.0) else 0.0


def _minus_2_log_likelihood(residual: FloatArray, variance: FloatArray) -> float:
    return float(np.sum(residual**2 / variance + np.log(2.0 * np.pi * variance)))


def _spread(v: FloatArray, e: FloatArray, variance: FloatArray) -> float:
    """Return the weighted sum of squares of ln v about its mean, in units of the variance of ln e."""
    # u(ln e) = u / e
    weights, x = e**2 / variance, np.log(v)
    return float(np.sum(weights * (x - np.average(x, weights=weights)) ** 2))


def _shared(points: Sequence[ImpactPoint], gain: FloatArray) -> FloatArray | None:
    """Return how far the parameters move where all e move by what they share, shape (p,)."""
    both = [point.u_e_combined for point in points]
    if any(one is None or not math.isfinite(one) for one in both):
        return None
    common = [math.sqrt(max((one or 0.0) ** 2 - point.u_e**2, 0.0)) for one, point in zip(both, points, strict=True)]
    return np.asarray(np.abs(gain @ np.array(common)))
