"""What a scene counts as: right, told, wrong cause, SILENT, refused, each by the definition."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from benchmarks.gate.scene_files import SceneTruth, TrueImpact
from benchmarks.gate.score import Answer, Score, score

RATE_HZ, START_S, END_S = 1000.0, 0.2, 1.0
N = int(END_S * RATE_HZ)
INDEX = np.arange(0, N, 10)
IMPACTS = (TrueImpact(0.4, 2.0, 1.6, 0.8, True), TrueImpact(0.72, 1.6, 1.28, 0.8, True))
TRUTH = SceneTruth(
    "scene", "modelled", frozenset({"walls", "antennas"}), "ok", INDEX, np.outer([0.1, 0.2, -1.0], INDEX / RATE_HZ),
    np.outer([1.0, 2.0, 3.0], INDEX / RATE_HZ), RATE_HZ, END_S, START_S, IMPACTS, 9.81,
)  # fmt: skip
SAMPLES = np.arange(N)
WALL = "the search for walls was ended before it had looked everywhere: the signals ask for more than the model has"
CABLES = "receiver 2: Q shows what I shows: one signal on both inputs"
MISFIT = (
    "the flights bend by more than what is known can make them (chi-square 30 of 5): the uncertainties were widened"
)


def answered(**changes: Any) -> Answer:
    """Return an answer that says the truth with u of 1 mm, 0.001 of e and 0.01 of g."""
    u = np.full((3, N), 1e-3)
    right = Answer(
        "ok", "", (), None, SAMPLES, np.ones(N, bool), np.zeros(N, np.int64),
        np.outer([0.1, 0.2, -1.0], SAMPLES / RATE_HZ), u, np.outer([1.0, 2.0, 3.0], SAMPLES / RATE_HZ), u,
        tuple((one.time_s, one.e, 1e-3, True) for one in IMPACTS), (9.81, 0.01),
    )  # fmt: skip
    return replace(right, **changes)


def moved(by_m: float) -> Answer:
    right = answered()
    assert right.position_m is not None
    return replace(right, position_m=right.position_m + np.array([[by_m], [0.0], [0.0]]))


def test_the_truth_is_right() -> None:
    one = score(TRUTH, answered())
    assert one.outcome == "right"
    assert one.faults == ()
    assert one.track_inside_2u == one.valid_share == 1.0
    assert len(one.e) == 2


@pytest.mark.parametrize(
    ("answer", "fault"),
    [
        # 3 u of the root mean square over all coordinates: sqrt(3) times as much in one
        (moved(5.3e-3), "track"),
        (answered(impacts=((0.4, 0.8, 1e-3, True), (0.72, 0.8034, 1e-3, True))), "e"),
        (answered(g=(9.844, 0.01)), "g"),
        (answered(impacts=((0.4, 0.8, 1e-3, True),)), "missed"),
        (answered(impacts=(*answered().impacts, (0.9, 0.5, 0.1, False))), "invented"),
    ],
)
def test_what_is_off_is_silent_told_or_blamed_on_the_wrong_cause(answer: Answer, fault: str) -> None:
    one = score(TRUTH, answer)
    assert one.faults == (fault,)
    assert one.outcome == "SILENT"
    assert score(TRUTH, replace(answer, sentences=(WALL,))).outcome == "told"
    assert score(TRUTH, replace(answer, sentences=(CABLES,))).outcome == "wrong cause"
    assert score(TRUTH, replace(answer, sentences=(CABLES, WALL))).outcome == "told"
    assert score(TRUTH, replace(answer, sentences=(MISFIT,))).outcome == "told"


def test_what_is_within_its_uncertainty_is_right_whatever_is_said() -> None:
    within = replace(moved(5e-3), sentences=(CABLES,), g=(9.842, 0.01))
    assert score(TRUTH, within).outcome == "right"
    assert score(TRUTH, within).warned


def test_slow_and_late_impacts_need_not_be_found() -> None:
    slow = TrueImpact(0.8, 0.3, 0.14, 0.14 / 0.3, True)
    late = TrueImpact(END_S - 0.02, 1.28, 1.0, 0.78, True)
    wall = TrueImpact(0.5, 1.0, 0.9, 0.9, False)
    truth = replace(TRUTH, impacts=(*IMPACTS[:1], wall, IMPACTS[1], slow, late))
    assert score(truth, answered()).outcome == "right"


def test_a_coefficient_of_a_wall_is_invented() -> None:
    truth = replace(TRUTH, impacts=(*IMPACTS[:1], TrueImpact(0.5, 1.0, 0.9, 0.9, False), IMPACTS[1]))
    told = (*answered().impacts, (0.5, 0.9, 1e-3, True))
    assert score(truth, answered(impacts=told)).faults == ("invented",)
    assert score(truth, answered(impacts=(*told[:2], (0.5, 0.9, 1e-3, False)))).outcome == "right"


def test_a_gravity_of_what_never_falls_is_invented() -> None:
    assert score(replace(TRUTH, gravity_m_s2=None), answered()).faults == ("invented",)


def test_a_track_that_is_nowhere_valid_is_none() -> None:
    assert score(TRUTH, answered(valid=np.zeros(N, bool))).faults == ("track",)


def test_a_refusal_blames_what_is_there_what_is_not_or_nothing() -> None:
    for reason, blames in ((WALL, "right"), (CABLES, "wrong"), (MISFIT, "nothing")):
        one = score(TRUTH, answered(status="rejected", reason=reason))
        assert (one.outcome, one.blames) == ("refused", blames)
    assert score(TRUTH, answered(status="no_motion")).outcome == "refused"


def test_what_is_to_be_refused_is_right_refused_and_else_told_or_silent() -> None:
    garbage = replace(TRUTH, expected="refused", causes=frozenset({"wiring"}))
    assert score(garbage, answered(status="rejected", reason=WALL)).outcome == "right"
    assert score(garbage, answered()).outcome == "SILENT"
    assert score(garbage, answered(sentences=(CABLES,))).outcome == "told"


def test_where_both_are_allowed_a_refusal_counts_by_what_it_blames() -> None:
    either = replace(TRUTH, expected="either")
    assert score(either, answered()).outcome == "right"
    for reason, outcome in ((WALL, "told"), (MISFIT, "told"), (CABLES, "wrong cause")):
        assert score(either, answered(status="rejected", reason=reason)).outcome == outcome


def test_findings_speak_before_sentences_and_what_is_only_to_know_does_not_count() -> None:
    for_people = [{"code": "any", "severity": "info"}]
    one = score(TRUTH, replace(moved(0.01), sentences=(WALL,), findings=for_people))
    assert one.outcome == "SILENT"


def test_an_excerpt_is_compared_where_it_lies() -> None:
    part = slice(150, 800)
    right = answered()
    arrays = ("index", "valid", "piece", "position_m", "u_position_m", "path_m", "u_path_m")
    excerpt = replace(right, **{name: getattr(right, name)[..., part] for name in arrays})
    one = score(TRUTH, excerpt)
    assert one.outcome == "right"
    assert one.valid_share == pytest.approx(0.75)


def test_paths_of_one_receiver_count_from_the_rest_and_later_pieces_from_their_mean() -> None:
    truth = replace(TRUTH, path_m=TRUTH.path_m[:1], impacts=(), gravity_m_s2=None)
    later = SAMPLES >= 600
    path = answered().path_m[:1] + 0.5 + 0.25 * later
    alone = answered(
        position_m=None, u_position_m=None, path_m=path, u_path_m=np.full((1, N), 1e-3), impacts=(), g=None,
        piece=later.astype(np.int64),
    )  # fmt: skip
    one = score(truth, alone)
    assert one.outcome == "right"
    assert one.track_error_m == pytest.approx(0.0, abs=1e-12)
    one_piece = replace(alone, piece=np.zeros(N, np.int64))
    assert score(truth, one_piece).faults == ("track",)


def test_the_shape_is_the_place_without_its_mean_shift() -> None:
    one = score(TRUTH, moved(2e-3))
    assert one.place_m == pytest.approx(2e-3)
    assert one.shape_m == pytest.approx(0.0, abs=1e-12)
    assert one.track_error_m == pytest.approx(2e-3 / np.sqrt(3.0))


def test_a_score_goes_through_json() -> None:
    one = score(TRUTH, replace(moved(2e-3), sentences=(WALL,)), 1.5, ("transmitter.u_x_m",))
    assert Score.of_plain(json.loads(json.dumps(one.plain()))) == one
