"""Words as people read them."""

from radargui.model.words import counted, percent, sentence, written_time


def test_one_thing_is_no_plural() -> None:
    assert [counted(count, "run") for count in (0, 1, 2)] == ["0 runs", "1 run", "2 runs"]


def test_a_sentence_has_a_capital_and_one_full_stop_and_a_symbol_stays_small() -> None:
    assert sentence("the floor moves.") == sentence("the floor moves") == "The floor moves."
    assert sentence("u of e is large") == "u of e is large."


def test_a_share_has_a_space_before_its_sign_and_a_time_no_millionths() -> None:
    assert [percent(share) for share in (0.0, 0.254, 1.0)] == ["0 %", "25 %", "100 %"]
    recorded = "2026-11-23T16:12:02.421931+01:00"
    assert written_time(recorded, "%Y-%m-%d %H:%M:%S %z", recorded) == "2026-11-23 16:12:02 +0100"
    assert written_time("in May", "%H:%M", "–") == "–"
