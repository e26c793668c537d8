"""Scores are kept, and setups go to versions that do not know all of their keys."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from benchmarks.gate import runs
from benchmarks.gate.runs import Population, Store
from benchmarks.gate.score import Score
from benchmarks.gate.versions import Version
from benchmarks.gate.worker import setup_of_version
from pydantic import ValidationError

import radargui

VERSION = Version("abc", "key", Path())
POPULATION = Population("modelled", 1)
SCORE = Score("ok", "", ("a sentence",), None, "ok", frozenset({"walls"}), track_error_m=1e-3, track_u_m=2e-3)
PLAIN = {
    "schema": 1,
    "radar": {"frequency_hz": 10e9},
    "transmitter": {"distance_m": 0.7},
    "receiver": [{"tilt_deg": 40.0, "azimuth_deg": 90.0, "distance_m": 0.7}],
}


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(runs, "KEPT", tmp_path)
    return tmp_path


def test_a_score_is_found_again_by_the_code_that_drew_its_scene_or_by_the_scene(kept: Path) -> None:
    Store(VERSION, POPULATION).put(3, "world", "scene", [SCORE])
    again = Store(VERSION, POPULATION)
    assert again.get(3, world="world") == again.get(3, scene="scene") == [SCORE]
    assert again.get(3, world="another", scene="another") is None
    assert again.get(4, world="world") is None
    assert Store(VERSION, Population("modelled", 2)).get(3, world="world") is None
    assert Store(VERSION, Population("modelled", 1, {"floor": 0.9})).get(3, world="world") is None


def test_an_interrupted_line_is_no_score_and_costs_no_other(kept: Path) -> None:
    store = Store(VERSION, POPULATION)
    store.put(1, "world", "scene", [SCORE])
    store.put(2, "world", "scene", [SCORE])
    (path,) = kept.rglob("*.jsonl")
    path.write_text(path.read_text(encoding="utf-8")[:-30], encoding="utf-8")
    store = Store(VERSION, POPULATION)
    assert store.get(1, world="world") == [SCORE]
    assert store.get(2, world="world") is None
    store.put(2, "world", "scene", [SCORE])
    assert Store(VERSION, POPULATION).get(2, world="world") == [SCORE]


def test_scores_that_came_with_the_checkout_are_found_too(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Store(VERSION, POPULATION).put(1, "world", "scene", [SCORE])
    (path,) = kept.rglob("*.jsonl")
    came = kept / "baseline" / VERSION.key / f"{POPULATION.file_name}.gz"
    came.parent.mkdir(parents=True)
    came.write_bytes(gzip.compress(path.read_bytes()))
    path.unlink()
    assert Store(VERSION, POPULATION).get(1, scene="scene") is None
    monkeypatch.setattr(runs, "BASELINE", kept / "baseline")
    assert Store(VERSION, POPULATION).get(1, scene="scene") == [SCORE]
    assert Store(VERSION, Population("modelled", 2)).get(1, scene="scene") is None


def test_keys_that_a_version_does_not_know_are_left_out_and_named() -> None:
    more = {
        **PLAIN,
        "receiver": [{**PLAIN["receiver"][0], "colour": "red"}],
        "moon": {"phase": 0.5},
    }
    setup, left_out = setup_of_version(more)
    assert setup == radargui.Setup.model_validate(PLAIN)
    assert sorted(left_out) == ["moon", "receiver.0.colour"]
    assert more["receiver"][0]["colour"] == "red"


def test_a_setup_that_is_wrong_in_another_way_stays_refused() -> None:
    with pytest.raises(ValidationError, match="distance_m"):
        setup_of_version({**PLAIN, "transmitter": {"distance_m": -1.0, "colour": "red"}})
