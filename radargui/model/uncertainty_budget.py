"""The uncertainty budget of a run: the shares of noise, of the antennas' calibration and of the sphere."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from radargui.model.arrays import FloatArray
from radargui.model.rounding import plain

Share = Literal["calibration", "sphere"]


@dataclass(frozen=True, slots=True)
class InputChange:
    """The change of the results when one input of the setup is off by its standard uncertainty.

    Attributes
    ----------
    key
        Key of the input, as in `model.assumed`.
    share
        The share of the budget that it belongs to.
    time_s
        Instants, shape (n,), the same for all inputs of a run: fewer than samples, for shifts are smooth.
    moved_m
        Change of the position, shape (3, n); NaN where unknown.
    e
        Change of each impact's e, shape (n_impacts,); NaN where unknown.
    g_m_s2
        Change of the acceleration in free fall; NaN where unknown.
    """

    key: str
    share: Share
    time_s: FloatArray = field(repr=False)
    moved_m: FloatArray = field(repr=False)
    e: FloatArray
    g_m_s2: float


@dataclass(frozen=True, slots=True)
class BudgetLine:
    """Standard uncertainties of one result, in its unit; None where unsupported.

    Attributes
    ----------
    statistical
        Share of noise and of all that the run itself determines; it differs between runs on one setup.
    calibration
        Share of antennas, release, floor, frequency and clock; it is common to runs on one setup.
    sphere
        Share of the diameter; without a stated polarisation, the error of taking the sphere for a point.
    combined
        All of them in squares (JCGM 100, 5.1.2).
    """

    statistical: float | None = None
    calibration: float | None = None
    sphere: float | None = None
    combined: float | None = None


@dataclass(frozen=True, slots=True)
class UncertaintyBudget:
    """The uncertainty budget of position, e and g.

    Attributes
    ----------
    position_m
        Root mean square over the motion, one axis.
    e
        Of the first impact.
    g_m_s2
        Of the acceleration measured.
    assumed
        Uncertainties that the setup does not give, by key, and the values taken.
    """

    position_m: BudgetLine = BudgetLine()
    e: BudgetLine = BudgetLine()
    g_m_s2: BudgetLine = BudgetLine()
    assumed: Mapping[str, float] = field(default_factory=dict)


SHARES = ("statistical", "calibration", "sphere")


def variance_shares(line: BudgetLine) -> dict[str, float]:
    """Return how much of the square of the combined uncertainty each part holds; empty where it is not known."""
    # independent causes: their squares add
    squares = {share: (getattr(line, share) or 0.0) ** 2 for share in SHARES}
    whole = sum(squares.values())
    return {share: square / whole for share, square in squares.items()} if line.combined and whole else {}


def budget_rows(budget: UncertaintyBudget) -> list[tuple[str, ...]]:
    """Return a budget as a table for people: a header, then position, e and g, two digits each (GUM 7.2.6)."""
    # each in the unit that it is read in: as metres a position would be all zeros
    lines = (("position / mm", budget.position_m, 1e3), ("e", budget.e, 1.0), ("g / (m/s²)", budget.g_m_s2, 1.0))
    shares = (*SHARES, "combined")
    return [("u of", *shares)] + [
        (name, *(plain(getattr(line, share), 2, scale=scale) for share in shares)) for name, line, scale in lines
    ]
