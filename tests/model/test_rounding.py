"""Values and uncertainties are rounded as metrology does."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from radargui.model.rounding import UNKNOWN, alone, concise, plain, quantity, with_sign


@pytest.mark.parametrize(
    ("value", "u", "text"),
    [
        (0.81234567, 0.0012, "0.8123 ± 0.0012"),
        (0.8, 0.0012, "0.8000 ± 0.0012"),
        (9.8101, 0.0996, "9.81 ± 0.10"),
        (9.8101, 0.0994, "9.810 ± 0.099"),
        (9.81, 0.34, "9.81 ± 0.34"),
        (1234.5, 12.4, "1234 ± 12"),
        (1234.5, 250.0, "1230 ± 250"),
        (98765.0, 1250.0, "98800 ± 1200"),
        (-0.0001, 0.012, "0.000 ± 0.012"),
        (1.0, 1e-12, "1.0000000000000 ± 0.0000000000010"),
    ],
)
def test_u_has_two_digits_and_the_value_ends_at_the_same_decimal(value: float, u: float, text: str) -> None:
    assert quantity(value, u) == text


def test_a_unit_stands_behind_brackets_and_a_scale_is_applied_to_both() -> None:
    assert quantity(0.26002, 0.00013, "mm", 1e3) == "(260.02 ± 0.13) mm"


@pytest.mark.parametrize(
    ("value", "u", "text"),
    [
        (9.80931, 0.0041, "9.8093(41) m/s²"),
        (0.21, 0.30, "0.21(30) m/s²"),
        (12.34, 1.2, "12.3(1.2) m/s²"),
        (123.4, 12.0, "123(12) m/s²"),
        (9.8093, None, "9.809 m/s²"),
        (math.nan, 0.1, UNKNOWN),
        (None, 0.1, UNKNOWN),
    ],
)
def test_in_brackets_stand_the_last_digits_or_from_one_on_the_uncertainty_itself(
    value: float | None, u: float | None, text: str
) -> None:
    assert concise(value, u, "m/s²") == text


def test_in_brackets_too_a_scale_is_applied_to_both() -> None:
    assert concise(0.01234, 0.0012, "mm", 1e3) == "12.3(1.2) mm"


@pytest.mark.parametrize("value", [None, math.nan, math.inf])
def test_what_is_not_known_is_a_dash(value: float | None) -> None:
    assert quantity(value, 0.1) == UNKNOWN
    assert plain(value) == UNKNOWN


@pytest.mark.parametrize("u", [None, math.nan, 0.0, -1.0, math.inf])
def test_without_an_uncertainty_the_value_stands_alone(u: float | None) -> None:
    assert quantity(0.812345, u) == "0.8123"
    assert quantity(0.26, u, "mm", 1e3) == "260.0 mm"


def test_numbers_of_numpy_are_numbers() -> None:
    assert quantity(np.float64(0.8), np.float64(0.0012)) == "0.8000 ± 0.0012"
    assert plain(np.float64(0.26), 5, "mm", 1e3) == "260.00 mm"


def test_plain_numbers_keep_their_significant_digits() -> None:
    assert plain(0.00012345, 3) == "0.000123"
    assert plain(123456.0, 2) == "120000"
    assert plain(0.0) == "0"
    assert plain(1e-9, 3) == "1.00e-09"


@given(st.floats(-1e12, 1e12), st.floats(1e-15, 1e12))
def test_rounding_moves_a_value_by_at_most_half_of_the_last_digit_of_u(value: float, u: float) -> None:
    shown, shown_u = quantity(value, u).split(" ± ")
    digits = shown_u.replace(".", "").strip("0")
    assert len(digits) <= 2
    assert float(shown_u) == pytest.approx(u, rel=0.0501)
    assert abs(float(shown) - value) <= 0.0501 * float(shown_u) + 1e-15 * abs(value)
    assert len(shown.partition(".")[2]) == len(shown_u.partition(".")[2])


@pytest.mark.parametrize(
    ("value", "u", "text"),
    [
        (0.81234, 0.0012, "+0.8123"),
        (-0.00012, 0.0012, "-0.0001"),
        (0.00004, 0.0012, "0.0000"),
        (-0.00004, 0.0012, "0.0000"),
        (0.5, None, "+0.5000"),
        (None, 0.1, UNKNOWN),
    ],
)
def test_a_difference_alone_has_the_digits_of_its_uncertainty(value: float | None, u: float | None, text: str) -> None:
    assert alone(value, u, signed=True) == text


def test_what_rounds_to_nothing_has_no_sign() -> None:
    assert [with_sign(value, 1) for value in (0.26, 0.04, 0.0, -0.0, -0.04, -0.26)] == [
        "+0.3",
        "0.0",
        "0.0",
        "0.0",
        "0.0",
        "-0.3",
    ]
