"""What a setup says of its floor: T and R that agree leave no residual, and the slopes are those of the residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, RELEASE_M, WAVELENGTH_M, small_problem

from radargui.estimation.forward.parameters import lobe_places
from radargui.estimation.forward.stated_floor import StatedTerm, stated_term
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.problem import Start, linearise
from radargui.physics.mirrors import MirrorPlane
from radargui.physics.plate import Plate, StatedSurface

STEEL = StatedSurface(1.0, 0.05, Plate(None))


def stated(surface: StatedSurface | None) -> MirrorPlane:
    return replace(FLOOR_PLANE, surface=surface)


def term_of(start: Start, theta: np.ndarray) -> StatedTerm:
    found = stated_term(theta, start.problem.layout, start.problem.inputs)
    assert found is not None
    return found


def test_a_floor_of_which_nothing_is_said_has_no_term() -> None:
    start = small_problem((FLOOR_PLANE,)).start
    assert stated_term(start.state.theta, start.problem.layout, start.problem.inputs) is None


@pytest.mark.parametrize("surface", [STEEL, StatedSurface(0.6, 0.05)])
def test_slopes_are_those_of_the_residuals(surface: StatedSurface) -> None:
    start = small_problem((stated(surface),), reflection=-0.4, n_bins=20).start
    theta, step = start.state.theta, 1e-6
    theta[start.problem.layout.planes] = 0.01, -0.02, 0.003
    # what a tilt of the floor does to the lobes is left out
    theta[lobe_places(start.problem.layout)] = 0.0
    slopes = term_of(start, theta).slopes
    for place in np.flatnonzero(slopes.any(axis=0)):
        changes = []
        for sign in (1.0, -1.0):
            other = theta.copy()
            other[place] += sign * step
            changes.append(term_of(start, other).residual)
        assert slopes[:, place] == pytest.approx((changes[0] - changes[1]) / (2.0 * step), abs=1e-4)


def test_reflections_as_the_plate_has_them_leave_nothing() -> None:
    start = small_problem((stated(STEEL),), n_bins=20).start
    theta, layout = start.state.theta.copy(), start.problem.layout
    antennas = start.problem.inputs.antennas
    # a lobe that is the same everywhere: what is left is the way over the floor, on which the field turns over
    places = [layout.transmitter_lobe, *(own.receiver_lobe for own in layout.receivers)]
    reflections = [layout.transmitter_reflection, *(own.receiver_reflection for own in layout.receivers)]
    points = np.array([antennas.transmitter_m, *antennas.receivers_m])
    for lobe, reflection, point in zip(places, reflections, points, strict=True):
        theta[lobe] = 0.0
        image = FLOOR_PLANE.image(point, np.zeros(3))
        way = np.linalg.norm(RELEASE_M - image) - np.linalg.norm(RELEASE_M - point)
        t = -np.exp(2j * np.pi / WAVELENGTH_M * way)
        theta[reflection] = t.real, t.imag
    assert term_of(start, theta).residual == pytest.approx(np.zeros(8), abs=1e-6)


def test_the_joint_cost_and_its_slope_have_the_term() -> None:
    surface = StatedSurface(0.6, 0.05)
    said, unsaid = (small_problem((stated(one),), reflection=-0.4, n_bins=40).start for one in (surface, None))
    of_both = [linearise(one.problem, said.state) for one in (said, unsaid)]
    layout = said.problem.layout
    alike = [replace(one.problem, prior=said.problem.prior) for one in (said, unsaid)]
    slopes = [
        assemble(problem, said.state, at).slope[-layout.size :] for problem, at in zip(alike, of_both, strict=True)
    ]
    term = term_of(said, said.state.theta)
    assert slopes[0] - slopes[1] == pytest.approx(term.slopes.T @ term.residual)
    assert term.cost > 1.0
