"""How a solution follows other inputs: against a minimum that is sought with these."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import ANTENNAS, FLOOR_PLANE, RELEASE_M, small_problem

from radargui.estimation.posterior.input_response import STEP, OtherInputs, moved_inputs, possible_spheres
from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.estimation.solve.minimise import MINIMISE, minimise
from radargui.estimation.solve.problem import Start
from radargui.model.assumed import SUPPOSED_POLARIZATIONS_DEG, SUPPOSED_TURNS_DEG, uncertain_inputs
from radargui.model.setup import read_setup
from radargui.physics.path_length import place_antennas
from radargui.system.resources import default_setup_path

SHIFT_M = np.array([3e-4, -2e-4, 2.5e-4])
TIGHT = replace(MINIMISE, close=1e-9, nothing=1e-9)
K = 2.0 * np.pi / 0.03


def other(which: str) -> OtherInputs:
    if which == "antenna":
        moved = replace(ANTENNAS, receivers_m=ANTENNAS.receivers_m + np.array([SHIFT_M, 0.0 * SHIFT_M, 0.0 * SHIFT_M]))
        return OtherInputs(moved, RELEASE_M, K)
    if which == "release":
        return OtherInputs(ANTENNAS, RELEASE_M + SHIFT_M, K)
    return OtherInputs(ANTENNAS, RELEASE_M, K * 1.0005)


@pytest.mark.parametrize("which", ["antenna", "release", "wavelength"])
def test_a_motion_follows_another_input_as_the_minimum_with_it_does(which: str) -> None:
    made = small_problem((FLOOR_PLANE,), reflection=0.1, sigma=0.001)
    solution = minimise(Start(made.problem, made.truth), 30, TIGHT)
    inputs = other(which)
    time = np.linspace(0.08, 0.44, 50)
    (response,) = MotionPosterior(solution, 0.05).responses([inputs], time)
    there = replace(
        made.problem.inputs, antennas=inputs.antennas, release_m=inputs.release_m, wavenumber=inputs.wavenumber
    )
    again = minimise(Start(replace(made.problem, inputs=there), solution.state), 30, TIGHT)
    old, new = MotionPosterior(solution, 0.05), MotionPosterior(again, 0.05)
    moved = new.free.position_m(time) - old.free.position_m(time)
    assert STEP * response.moved_m == pytest.approx(moved, abs=0.01 * np.abs(moved).max())
    for own, side in ((response.before_m_s, "before_m_s"), (response.after_m_s, "after_m_s")):
        change = getattr(new.breaks, side) - getattr(old.breaks, side)
        assert STEP * own == pytest.approx(change, abs=0.01 * np.abs(change).max() + 5e-6)
    assert old.floor_slope is not None
    assert new.floor_slope is not None
    leans = new.floor_slope.slope - old.floor_slope.slope
    # Gauss-Newton leaves out how the floor's slope bends the signal: 2e-5 of a u of 1e-3
    assert STEP * response.floor_slope == pytest.approx(leans, abs=0.3 * np.abs(leans).max() + 2e-6)
    layout, shift = made.problem.layout, again.state.theta - solution.state.theta
    grown = [np.sqrt(np.mean(np.append(shift[own.bias_i], shift[own.bias_q]) ** 2)) for own in layout.receivers]
    # a ten-thousandth of an amplitude, where maps are no longer linear
    assert STEP * response.bias == pytest.approx(grown, rel=0.25)
    assert old.responses([], time) == ()


def test_without_a_floor_nothing_leans() -> None:
    solution = minimise(small_problem().start, 2)
    (response,) = MotionPosterior(solution, 0.05).responses([other("release")], np.array([0.1, 0.2]))
    assert response.floor_slope.tolist() == [0.0, 0.0]
    # a release elsewhere carries the motion along
    assert np.abs(response.moved_m).max() > 0.0


def test_inputs_are_moved_by_a_share_of_their_uncertainty() -> None:
    setup = read_setup(default_setup_path())
    first, *others = setup.receiver
    setup = setup.model_copy(update={"receiver": (first.model_copy(update={"u_distance_m": 0.002}), *others)})
    (one,) = (own for own in uncertain_inputs(setup) if own.key == "receiver[1].distance_m")
    moved, before = moved_inputs(setup, one), place_antennas(setup)
    away = moved.antennas.receivers_m - before.receivers_m
    assert away[0] == pytest.approx(STEP * 0.002 * before.receivers_m[0] / np.linalg.norm(before.receivers_m[0]))
    assert not away[1:].any()
    assert moved.release_m.tolist() == list(setup.tracer.release_position_m)
    assert moved.wavenumber == pytest.approx(2.0 * np.pi / setup.radar.wavelength_m)


def test_a_sphere_instead_of_a_point_has_antennas_turned_in_each_supposed_way() -> None:
    setup = read_setup(default_setup_path())
    inputs = possible_spheres(setup)
    assert len(inputs) == len(SUPPOSED_POLARIZATIONS_DEG) * len(SUPPOSED_TURNS_DEG)
    sent = [np.degrees(one.body.angle_rad[0]) for one in inputs if one.body is not None]
    assert sent == pytest.approx(np.repeat(SUPPOSED_POLARIZATIONS_DEG, 2))
    for one, other in zip(inputs[::2], inputs[1::2], strict=True):
        assert one.body is not None
        assert other.body is not None
        between = np.degrees(other.body.angle_rad - one.body.angle_rad)
        assert between == pytest.approx([0.0, *[np.ptp(SUPPOSED_TURNS_DEG)] * 3])
        assert one.wavenumber == pytest.approx(2.0 * np.pi / setup.radar.wavelength_m)
        assert one.release_m.tolist() == list(setup.tracer.release_position_m)
        assert one.antennas.receivers_m.tolist() == place_antennas(setup).receivers_m.tolist()
