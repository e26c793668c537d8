"""Populations: each scene again the same, what is held changes nothing else, setups that a program can read."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.kinds import KINDS, draw, draw_session

SEED = 20


@pytest.mark.parametrize("kind", KINDS)
def test_a_scene_is_the_same_again_and_its_record_too(kind: str) -> None:
    first, again = draw(kind, SEED, 1), draw(kind, SEED, 1)
    assert first.setup == again.setup
    assert first.causes == again.causes
    np.testing.assert_array_equal(first.record().recording.raw, again.record().recording.raw)


def test_what_is_held_changes_no_other_value() -> None:
    drawn, held = draw("modelled", SEED, 2), draw("modelled", SEED, 2, {"floor": 0.5, "walls": 1})
    changed = {key for key in drawn.facts if drawn.facts[key] != held.facts[key]}
    assert changed <= {"floor", "walls"}
    assert held.facts["floor"] == 0.5


def test_drops_of_a_session_share_setup_and_front_end_and_differ_in_what_happens() -> None:
    drops = draw_session("modelled", SEED, 3, 3, {"exact": False})
    assert all(one.setup == drops[0].setup for one in drops)
    first, *others = (one.record() for one in drops)
    released = [one.position_m[:, 0] for one in (first, *others)]
    scatter_m = drops[0].setup["tracer"]["u_release_scatter_m"]
    assert all(0.0 < np.abs(place - released[0]).max() < 8.0 * scatter_m for place in released[1:])
    assert all(one.impacts[0][3] != first.impacts[0][3] for one in others)


def test_what_cannot_be_held_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="no such values: flour"):
        draw("modelled", SEED, 0, {"flour": 1})
    with pytest.raises(ValueError, match="no such kind: flour"):
        draw("flour", SEED, 0)
