"""A model whose rounds ended where it has no minimum is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from radargui.processing.checks.estimate import no_minimum
from radargui.processing.checks.run import checks_of


def evidence(*, settled: bool) -> Any:
    estimate = SimpleNamespace(chosen=SimpleNamespace(solution=SimpleNamespace(settled=settled)))
    return SimpleNamespace(motion=SimpleNamespace(estimate=estimate))


@pytest.mark.parametrize("settled", [True, False])
def test_a_joint_estimate_without_a_minimum_is_told_with_what_that_means(settled: bool) -> None:
    assert no_minimum in checks_of(evidence(settled=settled))
    finding = no_minimum(evidence(settled=settled))
    assert (finding is None) is settled
    if finding is not None:
        assert (finding.code, finding.severity) == ("no_minimum", "warn")
        assert "farther off than their uncertainties say" in finding.text


def test_other_corrections_have_no_minimum_to_come_to() -> None:
    assert no_minimum(SimpleNamespace(motion=SimpleNamespace(estimate=None))) is None  # type: ignore[arg-type]
