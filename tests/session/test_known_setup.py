"""Antennas known from the other runs of a session: who counts, and that what is stored is read as it was."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.changed import changed
from support.file_samples import codes, default_setup, int16_digitisation, result_of

from radargui.files import hdf5
from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.files.stored_results import read_setup_likelihood, read_setup_prior
from radargui.model.recording import Block
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior
from radargui.model.setup_posterior import SetupLikelihood, unknown_inputs
from radargui.session.known_setup import known_setup_of_run
from radargui.session.session import Session

SETUP = changed(default_setup(), processing={"correction": "joint"})
N = len(unknown_inputs(SETUP)[0])


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return Session.create(tmp_path, SETUP, now=datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC))


def record(session: Session, setup: Setup = SETUP, **said: object) -> Path:
    """Record a run; its result, where it is given some, says of each value of the setup that it is as it is stated."""
    with session.new_run(int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 300), 0))
    if said:
        made = replace(result_of(read_run(writer.path)), setup=setup)
        write_results(writer.path, replace(made, **said))
    return writer.path


def told() -> SetupLikelihood:
    return SetupLikelihood(np.diag(np.arange(1.0, N + 1.0)), np.linspace(-1.0, 1.0, N))


def names(run: Path, setup: Setup = SETUP, *, again: bool = False) -> tuple[str, ...]:
    prior = known_setup_of_run(run, setup, only_again=again)
    return () if prior is None else prior.runs


def contradicts() -> SetupPrior:
    return SetupPrior(("run-0001",), (0.0,) * N, tuple(map(tuple, np.eye(N).tolist())), used=False)


def test_all_other_runs_on_the_same_antennas_count_but_those_set_aside(session: Session) -> None:
    other = changed(SETUP, radar={"frequency_hz": 9.5e9})
    first, second = record(session, setup_likelihood=told()), record(session, setup_likelihood=told())
    record(session, other, setup_likelihood=told())
    record(session)
    record(session, setup_likelihood=told())
    assert names(second) == ("run-0001", "run-0005")
    session.reject(first, "touched the wall")
    assert names(second) == ("run-0005",)


def test_a_run_that_contradicts_ends_the_pool_and_is_held_against_those_before_again(session: Session) -> None:
    for prior in (None, None, contradicts(), None):
        record(session, setup_likelihood=told(), setup_prior=prior)
    paths = sorted(session.path.glob("run-*.h5"))
    assert [names(path) for path in paths] == [
        ("run-0002",),
        ("run-0001",),
        ("run-0001", "run-0002"),
        ("run-0003",),
    ]


def test_who_does_not_pool_or_asks_for_another_correction_or_has_no_session_knows_nothing(
    session: Session, tmp_path: Path
) -> None:
    record(session, setup_likelihood=told())
    run = record(session)
    assert names(run)
    assert not names(run, changed(SETUP, processing={"pool_setup": False}))
    assert not names(run, changed(SETUP, processing={"correction": "adaptive"}))
    alone = tmp_path / "alone.h5"
    alone.write_bytes(run.read_bytes())
    assert not names(alone)


def test_of_runs_computed_together_only_those_know_others_that_were_of_the_same_antennas_before(
    session: Session,
) -> None:
    first, second = record(session, setup_likelihood=told()), record(session)
    third = record(session, setup_likelihood=told())
    assert names(first, again=True) == ("run-0003",)
    assert names(second, again=True) == ()
    moved = changed(SETUP, radar={"frequency_hz": 9.5e9})
    assert names(third, moved, again=True) == ()


def test_what_a_run_says_and_was_told_is_stored_and_an_old_or_damaged_one_says_nothing(session: Session) -> None:
    path = record(session, setup_likelihood=told(), setup_prior=contradicts())
    found = read_setup_likelihood(path)
    assert found is not None
    assert found.begins
    np.testing.assert_allclose(found.likelihood.matrix, told().matrix, atol=1e-12)
    np.testing.assert_array_equal(found.likelihood.vector, told().vector)
    assert read_setup_prior(path, SETUP) == contradicts()
    for stored in ('{"keys": [], "matrix": [[1.0]], "vector": [1.0]}', ""):
        with h5py.File(path, "r+") as file:
            file["results"].attrs["setup_likelihood"] = stored
            hdf5.seal(file["results"].attrs)
        assert read_setup_likelihood(path) is None
