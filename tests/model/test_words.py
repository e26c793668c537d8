"""Words as people read them."""

from radargui.model.words import counted, sentence


def test_one_thing_is_no_plural() -> None:
    assert [counted(count, "run") for count in (0, 1, 2)] == ["0 runs", "1 run", "2 runs"]


def test_a_sentence_has_a_capital_and_one_full_stop_and_a_symbol_stays_small() -> None:
    assert sentence("the floor moves.") == sentence("the floor moves") == "The floor moves."
    assert sentence("u of e is large") == "u of e is large."
