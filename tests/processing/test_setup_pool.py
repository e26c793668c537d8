"""Two drops on the same antennas: the second one knows what the first has said, unless it contradicts it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.scene import Record, make_record
from support.changed import changed

from radargui.api import Result, Run, process
from radargui.model.result import RunResult
from radargui.model.setup_posterior import SetupLikelihood, unknown_inputs


@pytest.fixture(scope="module")
def record() -> Record:
    """A drop whose antennas are off by what the setup states: 0.5 degrees and 3 mm."""
    return make_record(
        draw(5, "drawn", rate_hz=2000.0, snr_db=35.0, walls=0, lively=False, e=0.7, height_m=0.2, rest=0.25)
    )


@pytest.fixture(scope="module")
def drop(record: Record) -> Run:
    return Run(record.recording, record.scene.setup)


@pytest.fixture(scope="module")
def alone(drop: Run) -> Result:
    return process(drop)


def u_of(result: RunResult) -> dict[str, float]:
    return {one.key: one.u_found / one.u_stated for one in result.setup_posterior if one.u_stated}


@pytest.mark.slow
def test_a_drop_tells_what_the_setup_states_wrongly_by_as_much_as_it_says(record: Record, alone: Result) -> None:
    """The track keeps its shape, and e is known as if the antennas were not off."""
    result, scene = alone.details, record.scene
    assert result.status == "ok"
    assert result.track is not None
    moving = np.arange(record.truth.position_m.shape[1]) > scene.drop.start_s * scene.converter.rate_hz
    error = (result.track.position_m - record.truth.position_m)[:, moving & result.track.valid]
    shape = error - error.mean(axis=1, keepdims=True)
    assert np.sqrt((shape**2).sum(axis=0).mean()) < 2e-4
    first = result.bounces.impacts[0]
    assert first.u_e_combined < 1e-3 * first.e
    assert abs(first.e - scene.drop.impacts[0].e) < 3.0 * first.u_e_combined
    values = {one.key: one for one in result.setup_posterior}
    tilts = [values[f"receiver[{n}].tilt_deg"] for n in (1, 2, 3)]
    assert all(one.u_found < 0.5 * one.u_stated for one in tilts)
    assert all(one.pull is not None and abs(one.pull) < 4.0 for one in values.values() if one.pull is not None)


@pytest.mark.slow
def test_a_drop_that_is_told_of_another_knows_its_antennas_better_and_says_the_same_of_them_alone(
    drop: Run, alone: Result
) -> None:
    assert alone.details.setup_prior is None
    # another drop that knew the antennas ten times as well, and had them where this one has them
    said = alone.details.setup_likelihood
    assert said is not None
    at = np.array([(one.found - one.stated) / one.u_stated for one in alone.details.setup_posterior])
    matrix = 100.0 * said.matrix
    sharp = Result(replace(alone.details, setup_likelihood=SetupLikelihood(matrix, matrix @ at)))
    told = process(drop, session=[sharp]).details
    assert told.setup_prior is not None
    assert told.setup_prior.used
    assert told.setup_prior.runs == ("run 1",)
    u, before = u_of(told), u_of(alone.details)
    assert all(u[key] < 1.001 * before[key] for key in u)
    assert min(u[key] / before[key] for key in u) < 0.5
    assert told.setup_likelihood is not None
    np.testing.assert_allclose(told.setup_likelihood.matrix, said.matrix)
    # what both say is what one says: the track stays, and its u is smaller
    assert told.track is not None
    assert alone.details.track is not None
    apart = (told.track.position_m - alone.details.track.position_m)[:, told.track.valid]
    assert np.sqrt((apart**2).sum(axis=0).mean()) < 2e-4
    assert told.track.u_combined_m is not None
    assert alone.details.track.u_combined_m is not None
    assert np.nanmedian(told.track.u_combined_m) < np.nanmedian(alone.details.track.u_combined_m)


@pytest.mark.slow
def test_a_drop_after_an_antenna_was_pushed_is_measured_alone_and_says_which(drop: Run, alone: Result) -> None:
    said = alone.details.setup_likelihood
    assert said is not None
    keys = [one.key for one in unknown_inputs(drop.setup)[0]]
    before = np.zeros(len(keys))
    before[keys.index("receiver[2].tilt_deg")] = 3.0
    other = SetupLikelihood(said.matrix, said.vector + said.matrix @ before)
    session = [Result(replace(alone.details, setup_likelihood=other))]
    result = process(drop, session=session)
    assert result.details.setup_prior is not None
    assert not result.details.setup_prior.used
    assert any("run 1 say" in text and "receiver[2]" in text for text in result.warnings)
    np.testing.assert_allclose(result.position_m, alone.position_m, atol=1e-9)


@pytest.mark.slow
def test_a_setup_that_does_not_pool_leaves_each_run_to_itself(drop: Run, alone: Result) -> None:
    setup = changed(drop.setup, processing={"pool_setup": False})
    result = process(Run(drop.recording, setup), session=[alone])
    assert result.details.setup_prior is None
    np.testing.assert_allclose(result.position_m, alone.position_m, atol=1e-9)
