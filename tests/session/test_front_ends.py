"""Front ends known from the earlier runs of a session: who counts, who does not, and that nobody counts twice."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.file_samples import codes, default_setup, int16_digitisation, result_of

from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.files.stored_results import read_prior
from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import Finding, warn
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.recording import Block
from radargui.model.result import RunResult
from radargui.session.known_setup import known_front_ends
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
GAIN, ANGLE = 1.1, 4.0


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return Session.create(tmp_path, changed(default_setup(), processing={"correction": "joint"}), now=NOW)


def record(session: Session) -> Path:
    with session.new_run(int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 300), 0))
    return writer.path


def joint(
    path: Path, gain: float = GAIN, u_gain: float = 1e-3, finding: Finding | None = None, **keys: object
) -> RunResult:
    result = result_of(read_run(path))
    assert result.corrected is not None
    channels = tuple(
        ChannelQuality(
            str(k),
            gain_ratio=gain,
            quadrature_error_deg=ANGLE,
            finding=finding,
            u_gain_ratio=u_gain,
            u_quadrature_error_deg=0.1,
        )
        for k in (1, 2, 3)
    )
    return replace(result, corrected=replace(result.corrected, method="joint", channels=channels), **keys)


def test_the_first_run_of_a_session_and_a_run_outside_of_any_have_no_prior(session: Session, tmp_path: Path) -> None:
    first = record(session)
    assert known_front_ends(first, session.setup) is None
    alone = tmp_path / "alone.h5"
    alone.write_bytes(first.read_bytes())
    assert known_front_ends(alone, session.setup) is None


def test_earlier_joint_results_are_pooled_and_named(session: Session) -> None:
    for gain in (1.09, 1.11):
        path = record(session)
        write_results(path, joint(path, gain, 0.01))
    last, after = record(session), record(session)
    write_results(after, joint(after, 2.0))
    prior = known_front_ends(last, session.setup)
    assert prior is not None
    assert prior.runs == ("run-0001", "run-0002")
    assert [one.gain_ratio for one in prior.front_ends] == pytest.approx([1.1] * 3)
    assert prior.front_ends[0].u_gain_ratio == pytest.approx(np.hypot(0.01, 1e-3), rel=1e-6)
    assert prior.front_ends[0].quadrature_error_deg == pytest.approx(ANGLE)


def test_runs_set_aside_or_with_other_hardware_or_without_a_good_joint_result_do_not_count(session: Session) -> None:
    paths = [record(session) for _ in range(6)]
    write_results(paths[0], result_of(read_run(paths[0])))
    write_results(paths[1], joint(paths[1], finding=warn("signal_low")))
    other = changed(session.setup, radar={"frequency_hz": 9.5e9})
    write_results(paths[2], replace(joint(paths[2]), setup=other))
    write_results(paths[3], joint(paths[3]))
    session.reject(paths[3], "touched the wall")
    assert known_front_ends(paths[5], session.setup) is None
    session.restore(paths[3])
    moved = changed(session.setup, tracer={"release_position_m": (0.0, 0.0, 0.1)}, processing={"geometry": "plane"})
    prior = known_front_ends(paths[5], moved)
    assert prior is not None
    assert prior.runs == ("run-0004",)


def test_no_other_correction_asks_for_a_prior(session: Session) -> None:
    first, second = record(session), record(session)
    write_results(first, joint(first))
    assert known_front_ends(second, session.setup) is not None
    assert known_front_ends(second, changed(session.setup, processing={"correction": "adaptive"})) is None


def test_a_run_that_rests_on_others_does_not_say_it_again(session: Session) -> None:
    first, second, third, fourth = (record(session) for _ in range(4))
    write_results(first, joint(first))
    known = known_front_ends(second, session.setup)
    assert known is not None
    write_results(second, joint(second, front_end_prior=known))
    write_results(third, joint(third, front_end_prior=replace(known, used=False)))
    prior = known_front_ends(fourth, session.setup)
    assert prior is not None
    assert prior.runs == ("run-0001", "run-0003")


def test_a_result_tells_the_prior_it_had_and_can_be_made_again_with_it(session: Session) -> None:
    path = record(session)
    had = FrontEndPrior(("run-0001", "run-0002"), (FrontEnd(1.1, 0.001, 4.0, 0.05),) * 3, used=False)
    result = joint(path, front_end_prior=had)
    write_results(path, result)
    assert read_prior(path, result.setup) == had
    assert read_prior(path, changed(result.setup, processing={"geometry": "plane"})) is None
    write_results(path, joint(path))
    assert read_prior(path, result.setup) is None
