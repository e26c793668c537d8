"""The likelihood by samples: its slopes are those of its cost, slow noise of each channel included."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed

from radargui.calibration.likelihood import World
from radargui.calibration.preparing import prepare_fall, sample_problem
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.unknowns import antenna_unknowns, fall_unknowns, place_unknowns
from radargui.model.resources import default_setup_path
from radargui.model.setup import read_setup
from radargui.sources.simulated import simulate_recording

RELEASE = "tracer.release_position_m"


@pytest.fixture(scope="module")
def drop() -> tuple[World, SignalLikelihood]:
    """A drop whose offsets drift, under a setup that is a little off."""
    setup = changed(
        read_setup(default_setup_path()),
        daq={"rate_hz": 4000.0, "channel_skew_s": 0.0},
        simulation={"drift": 0.2, "rest_s": 0.8, "settle_s": 0.2, "restitution": 0.5},
    )
    recording, _ = simulate_recording(setup)
    place = tuple(setup.tracer.release_position_m)
    unknowns = [*antenna_unknowns(setup), *place_unknowns(setup, place, RELEASE), *fall_unknowns(setup)]
    world = World(setup, tuple(unknowns))
    ready = prepare_fall(recording, setup, RELEASE)
    own = np.array([one.value for one in ready.motion.own])
    begun = sample_problem(ready, setup, world.values(np.zeros(len(unknowns))), own)
    assert begun is not None
    assert begun.problem.layout.sizes.drift > 0
    return world, SignalLikelihood(begun.problem, begun.state.theta, ready.motion)


def test_the_slope_is_that_of_the_cost(drop: tuple[World, SignalLikelihood]) -> None:
    world, likelihood = drop
    rng = np.random.default_rng(3)
    z, own = 0.05 * rng.standard_normal(len(world.unknowns)), likelihood.start
    own = own + 0.02 * rng.standard_normal(own.size)
    here = likelihood.at(world, z, own)
    drift = [at for one in likelihood.problem.layout.receivers for at in (one.drift_i, one.drift_q)]
    n_own = len(likelihood.motion.own)
    parts = [slice(n_own + at.start, n_own + at.stop) for at in drift]
    for part in [*parts, slice(0, n_own), slice(n_own, own.size)]:
        along = np.zeros(own.size)
        along[part] = rng.standard_normal(along[part].size)
        step = 1e-4 / np.linalg.norm(along) * along
        ahead, behind = (likelihood.at(world, z, own + sign * step).cost for sign in (1.0, -1.0))
        assert (ahead - behind) / 2.0 == pytest.approx(float(here.inner_slope @ step), rel=0.02, abs=1e-6)
    along = 1e-3 * rng.standard_normal(z.size)
    ahead, behind = (likelihood.at(world, z + sign * along, own).cost for sign in (1.0, -1.0))
    assert (ahead - behind) / 2.0 == pytest.approx(float(here.slope @ along), rel=0.02)
