"""Block means do not depend on the pieces that samples come in."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from radargui.model.recording import Digitisation
from radargui.signals.averager import Averager

CODES = Digitisation(("I1", "Q1"), 1000.0, ((0.5, 1e-4), (0.0, -2e-4)))
VOLTS = Digitisation(("I1", "Q1"), 1000.0)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=20), st.integers(1, 9))
def test_the_means_are_those_of_the_whole_record(pieces: list[int], size: int) -> None:
    raw = np.random.default_rng(3).integers(-32768, 32768, (2, sum(pieces))).astype(np.int16)
    averager = Averager(CODES, size)
    edges = np.cumsum([0, *pieces])
    means = np.concatenate([averager.push(raw[:, a:b]) for a, b in itertools.pairwise(edges)], axis=1)
    n = raw.shape[1] // size
    expected = CODES.volts(raw)[:, : n * size].reshape(2, n, size).mean(axis=2)
    assert means == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert averager.waiting == raw.shape[1] - n * size


def test_what_is_not_a_number_is_left_out() -> None:
    raw = np.arange(24.0).reshape(2, 12)
    raw[0, 1] = np.nan
    raw[1, 4:8] = np.inf
    means = Averager(VOLTS, 4).push(raw)
    assert means[0] == pytest.approx([(0 + 2 + 3) / 3, 5.5, 9.5])
    assert means[1] == pytest.approx([13.5, 13.5, 21.5])
