"""The words of errors in the resources are those that the program asks for, with room for the facts that it gives."""

import ast
from collections.abc import Callable
from pathlib import Path
from string import Formatter
from typing import Any

import pytest

import radargui
from radargui.model.errors import FileError, fault_of, worded
from radargui.system.resources import resource_table

SOURCES = [path.read_text(encoding="utf-8") for path in Path(radargui.__file__).parent.rglob("*.py")]
WORDS: dict[str, Any] = resource_table("errors")


def places_of(name: str) -> set[str]:
    texts = [WORDS[name]["fact"], *WORDS[name].get("reasons", ()), WORDS[name].get("remedy", "")]
    return {place for text in texts for _, place, *_ in Formatter().parse(text) if place is not None}


def asked() -> list[tuple[str, list[str | None]]]:
    calls = [node for text in SOURCES for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
    named = [call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "worded"]
    return [
        (str(call.args[1].value), [one.arg for one in call.keywords])
        for call in named
        if isinstance(call.args[1], ast.Constant)
    ]


def test_each_error_that_is_asked_for_has_words_and_a_place_for_each_fact() -> None:
    found = asked()
    assert len(found) > 50
    for name, facts in found:
        assert name in WORDS
        # of facts that are gathered first the names stand elsewhere
        given = {one for one in facts if one is not None}
        assert given == places_of(name) if None not in facts else given <= places_of(name), name


def test_no_words_stand_there_for_nothing() -> None:
    whole = "\n".join(SOURCES)
    assert [name for name in WORDS if f'"{name}"' not in whole] == []
    for name, words in WORDS.items():
        assert set(words) <= {"fact", "reasons", "remedy"}, name


def test_facts_come_into_fact_reasons_and_remedy_of_an_error_of_the_kind_that_is_asked_for() -> None:
    error = worded(FileError, "unreadable", path="a {b}.csv", what="CSV", why="cut.")
    assert isinstance(error, FileError)
    assert error.message == "a {b}.csv cannot be read as CSV: cut."
    assert error.reasons == ("it is damaged or cut off", "it is another kind of file")
    assert (
        worded(FileError, "no_vector", path="p", name="x", shape="2 x 2", vectors="a, b").remedy
        == "Vectors in it: a, b."
    )


def test_where_the_words_cannot_be_read_an_error_still_tells_its_facts(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_more_files(*_: object, **__: object) -> str:
        raise OSError(24, "Too many open files")

    resource_table.cache_clear()
    monkeypatch.setattr(Path, "read_text", no_more_files)
    error = worded(FileError, "unwritable", path="run.h5", why="Too many open files")
    assert isinstance(error, FileError)
    assert error.message == "unwritable: path run.h5, why Too many open files"


def test_a_checkout_called_as_the_program_does_not_make_every_library_in_it_a_part_of_it() -> None:
    module: dict[str, Callable[[], None]] = {}
    path = "/home/somebody/radargui/.venv/lib/other.py"
    exec(compile("def fail():\n    raise ZeroDivisionError('oops')", path, "exec"), module)
    with pytest.raises(ZeroDivisionError) as caught:
        module["fail"]()
    # the test itself is the first frame, and no part of the program either
    told = fault_of(caught.value, "Reading").message
    assert told == "Reading failed unexpectedly: ZeroDivisionError: oops (other.py, line 2)"
