"""A series: a replay is no measurement, each drop counts once, statistics as the GUM has them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from radargui.model.drop import Drop, RunOrigin, drop_of
from radargui.restitution.series import drop_labels, series_of
from radargui.restitution.statistics import Statistics, statistics_of


def drop(number: int, e: float, **origin: object) -> Drop:
    return Drop(f"run-{number:04d}", RunOrigin(**{"samples": f"{number}", **origin}), e, 0.002)


MEASURED = [drop(1, 0.79), drop(2, 0.80), drop(3, 0.81)]


def test_mean_deviation_and_error_of_the_mean_are_those_of_the_guide() -> None:
    found = statistics_of([0.79, None, 0.80, math.nan, 0.81])
    assert found.n == 3
    assert found.mean == pytest.approx(0.80)
    assert found.standard_deviation == pytest.approx(0.01)
    assert found.standard_error == pytest.approx(0.01 / math.sqrt(3))
    assert found.words() == "0.8000 ± 0.0058"
    assert statistics_of([]) == Statistics(0)
    assert statistics_of([]).words() == "–"


def test_a_single_value_has_its_own_uncertainty_and_no_range() -> None:
    assert statistics_of([0.8], [0.0012]).words() == "0.8000 ± 0.0012"
    assert statistics_of([0.8]) == Statistics(1, 0.8)


def test_what_runs_share_does_not_average_out() -> None:
    e, own, both = [0.79, 0.80, 0.81], [0.003, 0.003, 0.003], [0.005, 0.005, 0.005]
    found = statistics_of(e, own, both)
    # 0.004 is common to the three, 0.01 / sqrt(3) is their scatter
    assert found.combined == pytest.approx(math.hypot(0.004, 0.01 / math.sqrt(3)))
    assert found.words() == "0.8000 ± 0.0070"
    assert statistics_of(e, own, [0.005, None, 0.005]).combined is None
    assert statistics_of([0.8], [0.003], [0.005]).words() == "0.8000 ± 0.0050"


def test_replays_change_nothing_among_measurements() -> None:
    alone = series_of(MEASURED)
    mixed = series_of(
        [*MEASURED, drop(4, 0.5, kind="replay", file="a.h5", first_sample=0), drop(5, 0.9, kind="simulated")]
    )
    assert (mixed.e, mixed.kind) == (alone.e, "measured")
    assert mixed.left_out == {"run-0004": "a replay is no drop of its own", "run-0005": "simulated"}
    assert mixed.words == "0.8000 ± 0.0058 (mean of 3 drops), 2 left out"


def test_a_mean_is_one_of_final_results_and_says_how_many_are_preliminary() -> None:
    final = replace(drop(1, 0.8), u_e=0.01, u_e_combined=0.012)
    quick = [replace(drop(n, 0.9), u_e=0.001, u_e_combined=0.002, preliminary=True) for n in (2, 3)]
    found = series_of([final, *quick])
    assert found.e == series_of([final]).e
    assert found.words == "0.800 ± 0.012 (1 drop), 2 preliminary"
    assert series_of(quick).words == "2 preliminary"
    summary = {"status": "ok", "e": 0.8, "u_e": 0.001, "preliminary": True}
    assert series_of([drop_of("run-0001", RunOrigin(), summary)]).e.n == 0


def test_a_run_file_that_cannot_be_read_does_not_make_a_series_of_measurements() -> None:
    simulated = [drop(1, 0.79, kind="simulated"), drop(2, 0.80, kind="simulated")]
    mixed = series_of([*simulated, drop_of("run-0003", RunOrigin("unknown"), None)])
    assert (mixed.kind, mixed.e, mixed.left_out) == ("simulated", series_of(simulated).e, {})
    assert series_of([drop_of("run-0003", RunOrigin("unknown"), None)]).e.n == 0


def test_a_file_replayed_again_is_one_drop_by_its_place_or_its_samples() -> None:
    first = drop(1, 0.8, kind="replay", file="a.h5", first_sample=300)
    place = replace(drop(2, 0.8001), origin=replace(first.origin, samples="cut elsewhere"))
    samples = replace(drop(3, 0.8), origin=replace(first.origin, file="copy.h5"))
    other = drop(4, 0.82, kind="replay", file="a.h5", first_sample=90000)
    found = series_of([first, place, samples, other])
    assert found.left_out == {"run-0002": "the same drop as run-0001", "run-0003": "the same drop as run-0001"}
    assert (found.e.n, found.kind) == (2, "replay")
    assert found.words.endswith("(mean of 2 drops), replay, 2 left out")


def test_what_is_not_known_of_two_runs_does_not_make_them_one() -> None:
    unknown = Drop("run-0001", RunOrigin("replay"), 0.8)
    assert series_of([unknown, replace(unknown, name="run-0002")]).left_out == {}


def test_drops_are_numbered_as_drops() -> None:
    measured, again = RunOrigin(), RunOrigin("replay")
    runs = [("a", measured, True), ("b", None, False), ("c", again, True), ("d", measured, True), ("e", None, True)]
    assert drop_labels(runs) == {"a": "1", "b": "–", "c": "R1", "d": "2", "e": "3"}


def test_a_summary_of_an_older_version_counts_as_seen_from_the_release() -> None:
    assert drop_of("run-0001", RunOrigin(), {"e": 0.8}).from_rest
    assert not drop_of("run-0001", RunOrigin(), {"e": 0.8, "from_rest": False}).from_rest
    assert drop_of("run-0001", RunOrigin(), None).e is None
