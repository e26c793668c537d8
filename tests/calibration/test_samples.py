"""The likelihood by samples: its slopes are those of its cost, slow noise of each channel included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from benchmarks.scoring.calibration_scenes import circled, laboratory
from support.changed import changed
from support.simulated_recording import simulate_recording

from radargui.calibration.fit import fit, unfitted
from radargui.calibration.likelihood import World
from radargui.calibration.preparing import Prepared, prepare_fall, prepare_known, sample_problem
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.unknowns import Unknown, antenna_unknowns, fall_unknowns, place_unknowns, with_polarisations
from radargui.model.errors import UsageError
from radargui.model.setup import Setup, read_setup
from radargui.system.resources import default_setup_path

RELEASE = "tracer.release_position_m"


@pytest.fixture(scope="module")
def drop() -> tuple[Setup, Prepared]:
    """A drop of a metal sphere whose offsets drift."""
    setup = changed(
        read_setup(default_setup_path()),
        transmitter={"polarization_deg": 30.0, "u_polarization_deg": 5.0},
        daq={"rate_hz": 4000.0, "channel_skew_s": 0.0},
        simulation={"drift": 0.2, "rest_s": 0.8, "settle_s": 0.2, "restitution": 0.5},
    )
    return with_polarisations(setup), prepare_fall(simulate_recording(setup)[0], setup, RELEASE)


def sampled(unknowns: list[Unknown], setup: Setup, ready: Prepared) -> tuple[World, SignalLikelihood]:
    """Return the drop by its samples."""
    world = World(setup, tuple(unknowns))
    own = np.array([one.value for one in ready.motion.own])
    begun = sample_problem(ready, setup, world.values(np.zeros(len(unknowns))), own)
    assert begun is not None
    return world, SignalLikelihood(begun.problem, begun.state.theta, ready.motion)


def _fallen(setup: Setup) -> list[Unknown]:
    place = tuple(setup.tracer.release_position_m)
    return [*place_unknowns(setup, place, RELEASE), *fall_unknowns(setup)]


@pytest.mark.slow
@pytest.mark.parametrize("polarised", [True, False])
def test_the_slope_is_that_of_the_cost(drop: tuple[Setup, Prepared], *, polarised: bool) -> None:
    setup, ready = drop
    unknowns = [*antenna_unknowns(setup, polarised=polarised), *_fallen(setup)]
    world, likelihood = sampled(unknowns, setup, ready)
    assert likelihood.problem.layout.sizes.drift > 0
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


def test_an_antenna_that_moves_takes_the_axes_of_its_polarisation_along(drop: tuple[Setup, Prepared]) -> None:
    setup, ready = drop
    turned = tuple(one.model_copy(update={"azimuth_deg": one.azimuth_deg + 0.3}) for one in setup.receiver)
    off = setup.model_copy(update={"receiver": turned})
    fields = []
    for which in (setup, off):
        unknowns = antenna_unknowns(which)
        world, likelihood = sampled([*unknowns, *_fallen(setup)], which, ready)
        values = world.values(np.zeros(len(world.unknowns)))
        for n, one in enumerate(setup.receiver, 1):
            values[f"receiver.{n}.azimuth_deg"] = one.azimuth_deg
        z = np.array([(values[one.name] - one.value) / one.u for one in world.unknowns])
        at = likelihood.sampled(world, z, likelihood.start)
        assert at.problem.inputs.sphere is not None
        fields.append(at.problem.inputs.sphere.basis)
    np.testing.assert_allclose(fields[1], fields[0], atol=1e-9)


def test_a_wrong_polarisation_is_found(tmp_path: Path) -> None:
    lab = laboratory(2886154, snr_db=36.0, rate_hz=600.0)
    record, path = circled(lab, tmp_path, centre_m=np.array([0.05, 0.03, 0.02]))
    setup = with_polarisations(lab.scene.setup)
    true = np.array([setup.transmitter.polarization_deg, *(one.polarization_deg for one in setup.receiver)])
    wrong = setup.transmitter.model_copy(update={"polarization_deg": true[0] + 8.0, "u_polarization_deg": 5.0})
    receivers = tuple(one.model_copy(update={"u_polarization_deg": 5.0}) for one in setup.receiver)
    turned = setup.model_copy(update={"transmitter": wrong, "receiver": receivers})
    unknowns = [one for one in antenna_unknowns(turned, polarised=True) if one.group == "polarization"]
    world, likelihood = sampled(unknowns, turned, prepare_known(record.recording, setup, path))
    found = fit(unfitted(world, [likelihood]), [likelihood], steps=8)
    off = np.degrees(world.polarisations(found.z)) - true
    u = np.sqrt(np.diag(found.covariance())) * [one.u for one in unknowns]
    assert (np.abs(off) < 2.0 * u).all()
    assert abs(off[0]) < 1.0
    with pytest.raises(UsageError, match="counts as a point"):
        with_polarisations(read_setup(default_setup_path()))


def test_slopes_are_those_of_the_channels_also_in_a_common_turn(drop: tuple[Setup, Prepared]) -> None:
    setup, ready = drop
    unknowns = [*antenna_unknowns(setup), *_fallen(setup)]
    world, likelihood = sampled(unknowns, setup, ready)
    z, own = np.zeros(len(unknowns)), likelihood.start
    at = likelihood.sampled(world, z, own)
    parts = likelihood.rows(world, z, at)
    turned = np.array([float(one.name.endswith("azimuth_deg")) for one in unknowns])
    risen = np.array([float(one.name == f"{RELEASE}.z") for one in unknowns])
    nearer = np.array([float(one.name.endswith("distance_m")) for one in unknowns])
    for along in (turned, risen, nearer):
        ahead, behind = (likelihood.sampled(world, z + sign * 1e-3 * along, own).residual for sign in (1.0, -1.0))
        for n, part in enumerate(parts):
            true = (ahead - behind)[2 * n : 2 * n + 2] / 2e-3
            shared = part.index < z.size
            found = (part.rows[:, :, shared] @ along[part.index[shared]]) * at.use
            assert np.linalg.norm(found - true) < 0.01 * np.linalg.norm(true)
