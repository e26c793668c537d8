"""Which channel is which, guessed from names and order."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from radargui.files.reading import guess_channel_map, pattern_of
from radargui.files.signals import ChannelInfo

SIX = ("I1", "Q1", "I2", "Q2", "I3", "Q3")


def infos(*names: str, count: int = 100) -> tuple[ChannelInfo, ...]:
    return tuple(ChannelInfo(name, count) for name in names)


def guessed(*names: str) -> tuple[str, list[str]]:
    guess = guess_channel_map(infos(*names))
    return guess.basis, [entry.variable for entry in guess.channel_map.entries] if guess.channel_map else []


@pytest.mark.parametrize(
    "names",
    [
        SIX,
        ("i_1", "q_1", "i_2", "q_2", "i_3", "q_3"),
        ("rx0/I", "rx0/Q", "rx1/I", "rx1/Q", "rx2/I", "rx2/Q"),
        ("Ch 1 in-phase", "Ch 1 quadrature", "Ch 2 in-phase", "Ch 2 quadrature", "Ch 3 in-phase", "Ch 3 quadrature"),
        ("RX1_real", "RX1_imag", "RX2_real", "RX2_imag", "RX3_real", "RX3_imag"),
        ("src1.I", "src1.Q", "src2.I", "src2.Q", "src3.I", "src3.Q"),
    ],
)
def test_names_that_tell_i_q_and_a_number_are_taken_in_whatever_order_they_come(names: tuple[str, ...]) -> None:
    shuffled = [names[place] for place in (5, 0, 3, 2, 4, 1)]
    assert guessed(*shuffled) == ("names", list(names))


def test_a_lone_pair_needs_no_number() -> None:
    assert guessed("Q", "I") == ("names", ["I", "Q"])


@pytest.mark.parametrize(
    ("names", "taken"),
    [
        (("ch0", "ch1", "ch2", "ch3"), ["ch0", "ch1", "ch2", "ch3"]),
        (("Voltage_1", "Voltage", "Voltage_0", "Voltage_2"), ["Voltage", "Voltage_0", "Voltage_1", "Voltage_2"]),
        (("Dev1/ai10", "Dev1/ai9"), ["Dev1/ai9", "Dev1/ai10"]),
        (("upper", "lower", "left"), ["upper", "lower"]),
        (tuple(f"x{k}" for k in range(11)), [f"x{k}" for k in range(8)]),
        (("I1", "Q2"), ["I1", "Q2"]),
        (("9" * 5000, "x"), ["9" * 5000, "x"]),
        (("I1", "Q1", "i_1", "q_1"), ["I1", "Q1", "i_1", "q_1"]),
    ],
)
def test_other_names_are_paired_in_the_order_of_their_numbers(names: tuple[str, ...], taken: list[str]) -> None:
    assert guessed(*names) == ("order", taken)


def test_times_and_channels_of_another_length_are_left_out() -> None:
    guess = guess_channel_map((*infos("Time (s)", "b", "a"), *infos("temperature", count=3)))
    assert guess.channel_map is not None
    assert [entry.variable for entry in guess.channel_map.entries] == ["b", "a"]


@pytest.mark.parametrize("names", [(), ("x",), ("time_s", "x")])
def test_less_than_a_pair_is_nothing(names: tuple[str, ...]) -> None:
    assert guessed(*names) == ("nothing", [])


def test_the_pattern_leaves_out_what_differs_from_file_to_file() -> None:
    assert pattern_of(infos("run 1/a", "run 1/b")) == pattern_of(infos("run 2/a", "run 2/b")) == ("a", "b")
    assert pattern_of(infos("x/a", "y/a")) == ("x/a", "y/a")


@given(st.lists(st.text(max_size=12), max_size=12, unique=True))
def test_whatever_the_names_a_guess_is_complete_pairs_of_them(names: list[str]) -> None:
    guess = guess_channel_map(infos(*names))
    if guess.channel_map is not None:
        used = [entry.variable for entry in guess.channel_map.entries]
        assert len(set(used)) == len(used) > 0 == len(used) % 2
        assert set(used) <= set(names)
