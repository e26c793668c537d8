"""Limit the work of the model search, and name the ways in which it ends without a model.

Work is counted, not timed, so that a result does not depend on the machine.
"""

from collections.abc import Callable

from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError
from radargui.model.finding import error_of, refuse
from radargui.model.words import sentence

BIN_ROUNDS = 1.0e6
"""Rounds times bins that may be spent: a drop of 500 bins beside a floor takes 75 rounds, a wall 50 before it walks."""
ROUNDS = (200, 800)
"""Fewest and most rounds whatever the number of bins: the fewest are enough for a long record without walls."""


class BudgetSpentError(SolveError):
    """The search has done as much as it may."""


class NoSingleBodyError(SolveError):
    """No model of one moving body comes near the signals.

    Parameters
    ----------
    misfit
        Typical chi-square of each receiver, shape (n_receivers,).
    """

    def __init__(self, misfit: FloatArray) -> None:
        self.finding = refuse("misfit_too_large", chi_square=tuple(misfit.tolist()))
        super().__init__(sentence(self.finding.text))
        self.misfit = misfit


class LooseMapsError(NoSingleBodyError):
    """The offsets of all receivers change with the place as much as the signal, and do not explain it either."""


class SearchBudget:
    """Rounds of convergence that the search for a model has left.

    Parameters
    ----------
    n_bins
        Number of bins, with which the cost of a round grows.
    round_done
        Called once a round; may raise to cancel.
    bin_rounds, rounds
        Rounds times bins that may be spent; the fewest and the most rounds.
    """

    def __init__(
        self,
        n_bins: int,
        round_done: Callable[[], None],
        bin_rounds: float = BIN_ROUNDS,
        rounds: tuple[int, int] = ROUNDS,
    ) -> None:
        # rounds, not seconds: a slow machine shall find the same
        self.rounds = min(max(rounds[0], round(bin_rounds / n_bins)), rounds[1])
        self.left = self.rounds
        self._round_done = round_done

    def spend(self) -> None:
        """Take one round.

        Raises
        ------
        BudgetSpentError
            None is left.
        """
        self._round_done()
        self.left -= 1
        if self.left < 0:
            raise error_of(BudgetSpentError, "search_too_long", rounds=self.rounds)
