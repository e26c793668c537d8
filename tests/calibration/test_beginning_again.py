"""A fit that went astray while its wall was missing begins again with antennas and walls as found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.changed import changed

from radargui.calibration import beginning_again
from radargui.calibration.beginning_again import Beginning, begun_again
from radargui.calibration.likelihood import PathLikelihood, World
from radargui.calibration.preparing import prepare_fall, sample_problem
from radargui.calibration.settling import approach
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.unknowns import antenna_unknowns, fall_unknowns, place_unknowns
from radargui.calibration.verdict import fit_paths
from radargui.estimation.select.wall_grid import upright_planes
from radargui.model.resources import default_setup_path
from radargui.model.setup import read_setup
from radargui.sources.simulated import simulate_recording

RELEASE = "tracer.release_position_m"
UP = np.array([0.0, 0.0, 1.0])
WALL_M, WALL_DEG, ASTRAY_M = 0.30, 40.0, 0.005


@pytest.mark.slow
def test_a_fall_that_went_astray_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    # one recording contradicts no other
    monkeypatch.setattr(beginning_again, "DISAGREEING", 1.0)
    setup = changed(
        read_setup(default_setup_path()),
        daq={"rate_hz": 2000.0, "channel_skew_s": 0.0},
        simulation={
            "rest_s": 0.3, "settle_s": 0.1, "restitution": 0.3, "snr_db": 40.0, "reflection": 0.1, "drift": 0.0,
            "wall_reflection": 0.06, "wall_distance_m": [WALL_M], "wall_azimuth_deg": [WALL_DEG],
        },
    )  # fmt: skip
    recording, _ = simulate_recording(setup)
    place = tuple(setup.tracer.release_position_m)
    unknowns = [*antenna_unknowns(setup), *place_unknowns(setup, place, RELEASE), *fall_unknowns(setup)]
    world, held = World(setup, tuple(unknowns)), np.array([bool(one.key) for one in unknowns])
    ready = prepare_fall(recording, setup, RELEASE)
    paths = PathLikelihood(ready.measured, ready.motion, setup.radar.wavelength_m)
    rough = fit_paths(world, [paths], held)
    n_own = len(ready.motion.own)
    values = [one.value + one.u * z for one, z in zip(ready.motion.own, rough.own[0][:n_own], strict=True)]
    begun = sample_problem(ready, setup, world.values(rough.z), np.array(values))
    assert begun is not None
    samples = SignalLikelihood(begun.problem, begun.state.theta, ready.motion)
    first = np.concatenate([rough.own[0][:n_own], np.zeros(samples.theta.size)])
    beginning = Beginning(rough, (paths,), (samples,), (first,))
    planes = upright_planes(np.zeros(3), UP, np.array([np.radians(WALL_DEG + 180.0)]), np.array([WALL_M]))
    beside, own = samples.with_mirrors((*begun.problem.inputs.planes, *planes), first)
    right = approach(world, [beside], rough, [own], lambda: None)
    # the sphere elsewhere, as a missing wall had left it
    z = right.found.z.copy()
    for n, one in enumerate(unknowns):
        if one.name == f"{RELEASE}.x":
            z[n] += ASTRAY_M / one.u
    (likelihood,) = right.likelihoods
    local = likelihood.at(world, z, right.found.own[0])
    astray = replace(right, found=replace(right.found, z=z, locals_=(local,)))
    assert astray.log_evidence < right.log_evidence - 100.0
    back = begun_again(beginning, astray, 1, UP, lambda: None)
    assert back.log_evidence > right.log_evidence - 10.0
    assert begun_again(beginning, right, 1, UP, lambda: None).log_evidence >= right.log_evidence
