"""What is said of a run: words from facts, receivers told together, what is stored and read again."""

import json
import re
from pathlib import Path

import pytest

from radargui.model.errors import ProcessingError, SolveError
from radargui.model.finding import Finding, as_stored, error_of, finding_in, refuse, texts, warn, why_of
from radargui.system.resources import resource_table

ROOT = Path(__file__).resolve().parents[2]
WEAK, CLIPPED = (("signal_low", {}), ("some_samples_clipped", {"share": 0.002}))


def of(receiver: int, severity: str, code: str, facts: dict[str, object]) -> Finding:
    return finding_in({"code": code, "severity": severity, "receiver": receiver, "facts": facts})


def test_facts_are_told_in_the_units_that_the_words_ask_for() -> None:
    assert warn("floor_gives_way", contact_s=0.00234).text.startswith(
        "the floor gives way: an impact lasts some 2.3 ms,"
    )
    assert warn("samples_lost", lost=12, gaps=1).text.startswith("12 samples of each channel were lost in 1 gap: ")
    assert "in 2 gaps:" in warn("samples_lost", lost=12, gaps=2).text
    assert warn("release_assumed", place_m=(0.0, 0.0, 0.12)).text.endswith("(0, 0, 0.12) m is assumed")


def test_a_fact_may_stand_for_a_phrase_that_tells_it_again() -> None:
    assert (
        warn("echo_lost", times=1, has_track=False).text == "the echo was lost once: path lengths start anew after it"
    )
    assert warn("echo_lost", times=3, has_track=True).text.startswith("the echo was lost 3 times: ")


def test_what_is_said_of_several_receivers_is_said_once() -> None:
    found = [of(1, "refuse", *WEAK), of(2, "refuse", *CLIPPED), of(3, "refuse", *WEAK)]
    low, clipped = "low signal-to-noise ratio", "0.2 % of the samples are clipped or left out"
    assert texts(found) == (f"receivers 1 and 3: {low}", f"receiver 2: {clipped}")
    assert texts([of(k, "warn", *WEAK) for k in (1, 2, 3)]) == (f"receivers 1, 2 and 3 are usable: {low}",)
    assert texts([of(4, "warn", *WEAK)]) == (f"receiver 4 is usable: {low}",)


def test_what_names_its_receiver_itself_is_not_told_of_it_twice() -> None:
    left_out = Finding("receiver_left_out", "warn", 2, {"cause": refuse("antenna_off")})
    assert texts([left_out, left_out]) == (left_out.text,) * 2
    assert left_out.text.startswith("receiver 2: I and Q show white noise")


def test_a_finding_is_read_again_as_it_was_stored() -> None:
    spans = refuse("dip_unexplained", spans=("0.100 to 0.200", "0.300 to 0.400"))
    for one in (Finding("dip_left_out", "warn", 2, {"cause": spans}), warn("nothing_moves"), as_stored("A warning.")):
        again = finding_in(json.loads(json.dumps(one.document())))
        assert again == one
        assert again.text == one.text


@pytest.mark.parametrize("damage", [{"severity": "sad"}, {"code": 3}, {"receiver": "2"}])
def test_a_damaged_finding_is_refused(damage: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="severity"):
        finding_in({**warn("nothing_moves").document(), **damage})


def test_what_a_newer_version_found_is_told_by_its_code() -> None:
    assert warn("found_by_another_version").text == "found by another version"


def test_an_error_says_why_as_a_finding_and_one_in_words_alone_as_these() -> None:
    error = error_of(ProcessingError, "few_extremes", peaks=2, valleys=1, remedy="Use a longer drop.")
    assert error.message == "Only 2 peaks and 1 valleys in the motion."
    assert why_of(error) == refuse("few_extremes", peaks=2, valleys=1)
    assert why_of(SolveError("It has no solution.")).text == "It has no solution"


def codes_in(folder: Path) -> set[str]:
    """Codes that the program makes."""
    called = re.compile(r"""\b(?:warn|refuse|info|Finding|error_of)\(\s*(?:\w+Error,\s*)?"(\w+)\"""")
    return {code for path in folder.rglob("*.py") for code in called.findall(path.read_text(encoding="utf-8"))}


def test_every_code_has_words_and_all_words_are_used() -> None:
    told = set(resource_table("findings"))
    assert codes_in(ROOT / "radargui") - told == set()


def test_the_table_of_the_file_formats_names_every_code() -> None:
    page = (ROOT / "docs" / "file-formats.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"`(\w+)`", page.partition("## Findings")[2]))
    assert set(resource_table("findings")) - listed == set()
