"""Numbers become text with fixed decimals exactly as Python would round them."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from radargui.files.fixed_point import Column, lines

numbers = hnp.arrays(np.float64, st.integers(1, 40), elements=st.floats(width=64))
sizes = st.sampled_from([1e-9, 1e-3, 1.0, 999.0, 1e6, 1e12])


def cells(column: Column) -> list[str]:
    return b"".join(lines([column])).decode().splitlines()


@given(numbers, st.sampled_from([0, 3, 6, 9, 12]))
def test_any_number_is_read_back_within_half_of_the_last_decimal(values: np.ndarray, decimals: int) -> None:
    for value, text in zip(values, cells(Column(values, decimals)), strict=True):
        if not math.isfinite(value):
            assert text == "nan"
            continue
        assert abs(float(text) - value) <= 0.5001 * 10.0**-decimals + 2e-16 * abs(value)
        assert len(text.partition(".")[2]) == decimals
        assert text.lstrip("-") == "0" or not text.lstrip("-").startswith("00")


@given(st.lists(st.integers(-(10**12), 10**12), min_size=1, max_size=30))
def test_whole_numbers_are_written_as_python_writes_them(values: list[int]) -> None:
    assert cells(Column(np.array(values, dtype=np.float64), 0)) == [str(value) for value in values]


@given(hnp.arrays(np.float64, st.integers(1, 40), elements=st.floats(-1000.0, 1000.0)))
def test_six_decimals_are_those_of_python(values: np.ndarray) -> None:
    for value, text in zip(values, cells(Column(values, 6)), strict=True):
        assert abs(float(text) - float(f"{value:.6f}")) <= 1.01e-6
        assert len(text) == len(f"{float(text) + 0.0:.6f}")


@given(hnp.arrays(np.float64, 10, elements=st.floats(0.0, 1.0)))
def test_an_uncertainty_is_rounded_up_and_only_zero_is_zero(values: np.ndarray) -> None:
    for value, text in zip(values, cells(Column(values, 9, upwards=True)), strict=True):
        assert float(text) >= value * (1 - 1e-15)
        assert float(text) - value <= 1.0001e-9


def test_rows_longer_than_one_piece_keep_their_order() -> None:
    values = np.arange(30_000, dtype=np.float64)
    text = b"".join(lines([Column(values, 0), Column(values > 10, 0)])).decode()
    assert text.splitlines()[20_000] == "20000,1"
    assert text.splitlines()[5] == "5,0"
    assert text.count("\n") == 30_000
