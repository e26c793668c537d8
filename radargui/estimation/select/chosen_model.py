"""The chosen model: the solution, the alternatives that the evidence does not rule out, the decisions."""

from __future__ import annotations

from dataclasses import dataclass

from radargui.estimation.solve.minimise import Solution
from radargui.model.setup_posterior import SetupPosterior


@dataclass(frozen=True)
class Alternative:
    """A solution that the evidence does not rule out, with its weight against the best, 0 to 1."""

    solution: Solution
    weight: float


@dataclass(frozen=True)
class ChosenModel:
    """The joint solution and what was chosen on the way.

    Attributes
    ----------
    solution
        The solution.
    alternatives
        Other solutions; their uncertainties and their distances from the solution belong to the uncertainty.
    choices
        Sentences for people.
    ended_early
        Whether the search spent its budget; then all models that were compared count alike in the uncertainty.
    setup
        What the recording says of antennas, release and wave, which all solutions hold where they found them; None
        where it says nothing.
    """

    solution: Solution
    alternatives: tuple[Alternative, ...]
    choices: tuple[str, ...]
    ended_early: bool = False
    setup: SetupPosterior | None = None
