"""What the search for a model may spend: rounds, by the number of bins."""

from __future__ import annotations

import pytest

from radargui.estimation.select.budget import BudgetSpentError, SearchBudget


@pytest.mark.parametrize(("n_bins", "rounds"), [(400, 800), (1250, 800), (2000, 500), (4000, 250), (50000, 200)])
def test_a_million_rounds_times_bins_but_never_fewer_than_200_nor_more_than_800(n_bins: int, rounds: int) -> None:
    assert SearchBudget(n_bins, lambda: None).rounds == rounds


def test_each_round_is_told_and_the_one_too_many_ends_the_search() -> None:
    told: list[None] = []
    budget = SearchBudget(4000, lambda: told.append(None))
    for _ in range(250):
        budget.spend()
    assert (budget.left, len(told)) == (0, 250)
    with pytest.raises(BudgetSpentError, match="within 250 rounds"):
        budget.spend()
