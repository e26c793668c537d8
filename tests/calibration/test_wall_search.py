"""Walls are sought with everything else marginalised, and only where no motion goes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.room_with_wall import UP, WALL_DEG, WALL_M, room_with_wall

from radargui.calibration.fit import AT_LAST, Fit, Settled, approach, settled_at_last, settling
from radargui.calibration.preparing import sample_problem
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.wall_search import linearised_gains
from radargui.estimation.select.wall_grid import upright_planes


@pytest.fixture(scope="module")
def fitted() -> Settled:
    """Return a drop beside a wall, fitted without it by the antennas that are true."""
    room = room_with_wall(4000.0)
    setup, unknowns, world, ready = room.setup, room.unknowns, room.world, room.ready
    own = np.array([one.value for one in ready.motion.own])
    begun = sample_problem(ready, setup, world.values(np.zeros(len(unknowns))), own)
    assert begun is not None
    one, z = SignalLikelihood(begun.problem, begun.state.theta, ready.motion), np.zeros(len(unknowns))
    start = Fit(world, z, (one.start,), (one.at(world, z, one.start),), np.array([bool(u.key) for u in unknowns]))
    return approach(start, [one], start.own)


def test_a_wall_is_seen_where_it_is(fitted: Settled) -> None:
    azimuth, distance = np.radians(np.arange(0.0, 360.0, 24.0)), np.array([0.15, 0.21, WALL_M, 0.42])
    # azimuths of planes count from -x towards -y (`tangents`)
    azimuth = azimuth + np.radians(WALL_DEG + 180.0)
    gains = linearised_gains(fitted, upright_planes(np.zeros(3), UP, azimuth, distance)).reshape(15, 4)
    assert np.unravel_index(np.argmax(gains), gains.shape) == (0, 2)
    assert gains[0, 2] > gains[3:13].max() + 10.0


def test_deviations_that_follow_until_nothing_is_gained_never_lose(fitted: Settled) -> None:
    (one,), found = fitted.likelihoods, fitted.found
    assert isinstance(one, SignalLikelihood)
    # deviations ten times too wide: one renewal does not bring them back
    prior = one.problem.prior
    sd = prior.sd.copy()
    for group in prior.groups:
        sd[group.index] = np.minimum(10.0 * sd[group.index], group.highest)
    wide, own = one.with_prior(replace(prior, sd=sd), found.own[0])
    (first,) = settling(found, [wide], [own], 0)
    last = settled_at_last(first)
    assert last.log_evidence > first.log_evidence + AT_LAST


def test_a_new_mirror_changes_nothing_before_it_reflects(fitted: Settled) -> None:
    (one,), found = fitted.likelihoods, fitted.found
    assert isinstance(one, SignalLikelihood)
    (plane,) = upright_planes(np.zeros(3), UP, np.array([1.0]), np.array([0.3]))
    other, own = one.with_mirrors((plane,), found.own[0])
    # maps start again with the mirrors: without them in both the model is the same
    bare, state = one.with_mirrors((), found.own[0])
    layout, theta = bare.problem.layout, bare.theta.copy()
    for receiver in layout.receivers:
        theta[receiver.bias_i] = theta[receiver.bias_q] = 0.0
    bare = replace(bare, theta=theta)
    a, b = (which.sampled(found.world, found.z, at).residual for which, at in ((bare, state), (other, own)))
    np.testing.assert_allclose(a, b, atol=1e-12)
