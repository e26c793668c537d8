"""What sentences of versions without codes blame, and what codes do."""

from __future__ import annotations

import pytest
from benchmarks.gate.causes import CAUSES_OF_CODE, causes_of_finding, causes_of_sentence, named

from radargui.system.resources import resource_table

WIDENED = "the uncertainties of track, e and g were widened 3.1 times"
GUESS = "likely a reflector that is not in the model, or a setup that is wrong by more than it says;"
BENDS = "the flights bend by more than what is known can make them (chi-square 90 of 10):"
OFF = "would agree (9 times what it is known to): measure it again; the uncertainties count it as so far off"
SETUP = "flights and g contradict the setup: likely"


@pytest.mark.parametrize(
    ("sentence", "blames", "never"),
    [
        (
            f"{BENDS} {GUESS} {WIDENED}",
            {"walls", "antennas"},
            {"disturbance"},
        ),
        (f"{BENDS} likely a setup that is wrong by more than it says; {WIDENED}", {"antennas", "release"}, {"walls"}),
        (f"{BENDS} {WIDENED}", set(), {"walls", "antennas"}),
        ("there is no rest before the motion: the track is laid so that it begins", {"motion"}, {"release"}),
        (f"{SETUP} receiver[2] is wrong, adding tilt_deg +3 {OFF}", {"antennas"}, {"release", "wiring"}),
        (f"{SETUP} tracer.release_position_m is wrong, adding x +31 mm {OFF}", {"release"}, {"antennas", "wiring"}),
        (f"{SETUP} receiver[2] (or receiver[3], or receivers are exchanged) is wrong {OFF}", {"wiring"}, {"release"}),
    ],
)
def test_a_sentence_blames_what_it_names(sentence: str, blames: set[str], never: set[str]) -> None:
    found = causes_of_sentence(sentence)
    assert found is not None
    assert blames <= found
    assert not never & found


@pytest.mark.parametrize(
    ("code", "facts", "blames", "never"),
    [
        ("flights_bend", {"guess": "reflector"}, {"walls", "antennas"}, {"disturbance"}),
        ("flights_bend", {"guess": "setup"}, {"antennas"}, {"walls"}),
        ("flights_bend", {"guess": ""}, set(), {"walls", "antennas"}),
        ("setup_contradicted", {"place": "receiver[2]"}, {"antennas"}, {"release", "wiring"}),
        ("setup_contradicted", {"place": "tracer.release_position_m"}, {"release"}, {"antennas"}),
        ("setup_contradicted", {"place": "tracer.diameter_m"}, {"sphere"}, {"antennas", "release"}),
        ("setup_contradicted", {"place": "receiver[1]", "beside": "exchanged"}, {"wiring"}, {"release"}),
        ("off_circle", {"share": 0.4, "weak": True}, {"signal"}, {"disturbance"}),
        ("off_circle", {"share": 0.4}, set(), {"signal"}),
        ("receiver_left_out", {"cause": {"code": "cable_on_both", "facts": {}}}, {"wiring"}, {"antennas"}),
    ],
)
def test_a_finding_blames_what_its_code_and_facts_name(
    code: str, facts: dict[str, object], blames: set[str], never: set[str]
) -> None:
    found = causes_of_finding({"code": code, "severity": "warn", "facts": facts})
    assert found is not None
    assert blames <= found
    assert not never & found


def test_every_code_of_this_version_stands_in_the_table() -> None:
    assert set(resource_table("findings")) - set(CAUSES_OF_CODE) == set()


def test_what_no_table_knows_blames_nothing_and_is_told() -> None:
    for found in (named(["the moon is full"], None), named([], [{"code": "moon_full", "severity": "warn"}])):
        assert len(found.unknown) == 1
        assert found.nothing
        assert not found.causes


def test_nothing_said_is_nothing_named() -> None:
    assert named([], None) == named(["of no weight"], []) == (frozenset(), False, ())
    assert named([], [{"code": "flights_bend", "severity": "info"}]) == (frozenset(), False, ())
