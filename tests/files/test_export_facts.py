"""The facts that travel with exported samples: what is written is what is read, and nothing hostile gets through."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from radargui.files.run_file import ExportFacts, commented, facts_of_table, facts_of_text, uncommented
from radargui.model.recording import Digitisation, Gap, Marker

TEXT = st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\0"), max_size=40)
INDEX = st.integers(0, 2**50)
NUMBER = st.floats(-1e6, 1e6, allow_nan=False)


@st.composite
def facts(draw: st.DrawFn) -> ExportFacts:
    n_channels = draw(st.integers(1, 4))
    row = st.lists(NUMBER, min_size=1, max_size=4).map(tuple)
    scaling = draw(st.none() | st.lists(row, min_size=n_channels, max_size=n_channels).map(tuple))
    return ExportFacts(
        name=draw(TEXT),
        digitisation=Digitisation(
            tuple(f"{draw(TEXT)}{place}" for place in range(n_channels)),
            draw(st.floats(1e-3, 1e9)),
            scaling,
            draw(NUMBER),
            draw(TEXT)[:32],
            draw(TEXT),
        ),
        n_samples=draw(INDEX),
        gaps=tuple(Gap(draw(INDEX), draw(st.integers(1, 9)), draw(TEXT)) for _ in range(draw(st.integers(0, 3)))),
        trigger_index=draw(st.none() | INDEX),
        started_at=draw(TEXT),
        markers=tuple(Marker(draw(INDEX), draw(TEXT)) for _ in range(draw(st.integers(0, 3)))),
        setup_toml=draw(TEXT),
        session=draw(st.dictionaries(TEXT, TEXT, max_size=3)),
    )


@settings(deadline=None, max_examples=60)
@given(facts())
def test_facts_come_back_from_text_from_comments_and_from_json(before: ExportFacts) -> None:
    text = before.text()
    assert facts_of_text(text) == before
    assert facts_of_table(json.loads(json.dumps(before.table()))) == before
    # A file that is read as text knows three ends of a line.
    lines = io.StringIO(commented(text.rstrip("\n")), newline=None).readlines()
    assert facts_of_text(uncommented(lines)) == before


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
SOUND = ExportFacts("a", Digitisation(("I1", "Q1"), 1e3, ((0.0, 1.0), (0.0, 1.0))), 5, (Gap(2, 1, "x"),), 3).table()


@settings(deadline=None, max_examples=60)
@given(st.sampled_from(sorted(SOUND)), JSON)
def test_a_fact_of_any_other_kind_is_refused_or_sound(key: str, value: Any) -> None:
    found = facts_of_table({**SOUND, key: value})
    if found is not None:
        assert found.digitisation.sample_rate_hz > 0
        assert all(gap.count > 0 and gap.first_index >= 0 for gap in found.gaps)
        assert found.trigger_index is None or found.trigger_index >= 0
        found.text()


@pytest.mark.parametrize("text", ["", "format = 1", 'format = "radargui-export"', "[" * 5000 + "radargui-export", "\0"])
def test_what_is_no_table_of_facts_is_none(text: str) -> None:
    assert facts_of_text(text) is None
