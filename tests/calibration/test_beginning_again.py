"""A fit that went astray while its wall was missing begins again with antennas and walls as found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.room_with_wall import RELEASE, UP, room_with_wall, true_wall

from radargui.calibration.calibrate import Beginning, begun_again
from radargui.calibration.fit import approach, unfitted
from radargui.calibration.likelihood import PathLikelihood
from radargui.calibration.preparing import sample_problem
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.verdict import fit_paths

ASTRAY_M = 0.005


@pytest.mark.slow
def test_a_fall_that_went_astray_comes_back() -> None:
    room = room_with_wall(2000.0)
    setup, unknowns, world, ready = room.setup, room.unknowns, room.world, room.ready
    held = np.array([bool(one.key) for one in unknowns])
    paths = PathLikelihood(ready.measured, ready.motion, setup.radar.wavelength_m)
    rough = fit_paths(unfitted(world, [paths], held), [paths])
    n_own = len(ready.motion.own)
    values = [one.value + one.u * z for one, z in zip(ready.motion.own, rough.own[0][:n_own], strict=True)]
    begun = sample_problem(ready, setup, world.values(rough.z), np.array(values))
    assert begun is not None
    samples = SignalLikelihood(begun.problem, begun.state.theta, ready.motion)
    first = np.concatenate([rough.own[0][:n_own], np.zeros(samples.theta.size)])
    beginning = Beginning(rough, (paths,), (samples,), (first,))
    beside, own = samples.with_mirrors(true_wall(), first)
    right = approach(rough, [beside], [own])
    # the sphere elsewhere, as a missing wall had left it
    z = right.found.z.copy()
    for n, one in enumerate(unknowns):
        if one.name == f"{RELEASE}.x":
            z[n] += ASTRAY_M / one.u
    (likelihood,) = right.likelihoods
    local = likelihood.at(world, z, right.found.own[0])
    astray = replace(right, found=replace(right.found, z=z, locals_=(local,)))
    assert astray.log_evidence < right.log_evidence - 100.0
    # one recording contradicts no other
    back = begun_again(beginning, astray, 1, UP, disagreeing=1.0)
    assert back.log_evidence > right.log_evidence - 10.0
    assert begun_again(beginning, right, 1, UP, disagreeing=1.0).log_evidence >= right.log_evidence
