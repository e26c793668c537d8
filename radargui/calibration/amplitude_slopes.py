"""Derivatives of amplitudes by places of antennas and tracer: the range factor, and what a sphere scatters.

If everything is turned about the vertical together no path changes; the polarised sphere alone shows such a turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.calibration.likelihood import STEP, World
from radargui.estimation.forward.parameters import polarisation_places
from radargui.estimation.forward.sphere import signals_of
from radargui.estimation.forward.thinned import Thinned
from radargui.estimation.solve.problem import JointProblem
from radargui.geometry.path_length import Antennas, range_factor
from radargui.model.arrays import ComplexArray, FloatArray

PLACE_STEP_M = 1e-5
"""Of differences in one direction: fields change over centimetres, so slopes are off by 1e-3 at most."""
EACH = 4
"""Of so many bins one is looked at, a sixth of a fringe: directions and what is scattered change over centimetres."""


@dataclass(frozen=True)
class AmplitudeSlopes:
    """Slopes of G_ab over G_00, shape (n_receivers, 1 + n_mirrors, 1 + n_mirrors, n_bins).

    G_ab is the wave over the ways a and b divided by the direct wave at rest, without the phases of paths and without
    reflections: range factor times F_ab / F_rest.

    Attributes
    ----------
    by_unknown
        Slopes by shared unknowns, by number, in prior deviations.
    by_place, by_rest
        Slopes by x, y, z of the place, and of the place at rest, 1/m.
    """

    by_unknown: dict[int, ComplexArray]
    by_place: tuple[ComplexArray, ...]
    by_rest: tuple[ComplexArray, ...]

    def of_channels(self, receiver: int, pairs: ComplexArray) -> tuple[dict[int, FloatArray], FloatArray, FloatArray]:
        """Return the slopes of a receiver's channels by unknowns, place and rest, (2, n_bins), (3, 2, n_bins) twice.

        Parameters
        ----------
        receiver
            Number.
        pairs
            The wave over each pair of ways as if all scattered like the straight one, (..., ..., 2, n_bins).
        """

        def shown(slope: ComplexArray) -> FloatArray:
            return np.asarray((pairs * slope[receiver][:, :, None]).real.sum(axis=(0, 1)))

        by_unknown = {number: shown(slope) for number, slope in self.by_unknown.items()}
        by_place, by_rest = (np.array([shown(one) for one in axes]) for axes in (self.by_place, self.by_rest))
        return by_unknown, by_place, by_rest


def amplitude_slopes(
    world: World, z: FloatArray, problem: JointProblem, theta: FloatArray, place_m: FloatArray
) -> AmplitudeSlopes:
    """Return the slopes at a state.

    Parameters
    ----------
    world, z
        Shared unknowns.
    problem, theta
        With the antennas of the state; mismatch.
    place_m
        At the bins, shape (3, n_bins).
    """
    rest_m, antennas = problem.inputs.release_m, problem.inputs.antennas
    angle, unknown = theta[polarisation_places(problem.layout)], problem.layout.plane_unknowns(theta)

    def received(place: FloatArray, antennas: Antennas, n_planes: int = len(problem.inputs.planes)) -> ComplexArray:
        # the direct way's range for all: by how much a mirrored one is longer `log_ways` knows
        near = range_factor(place, antennas, rest_m)[:, None, None]
        if problem.sphere is None:
            return np.asarray(near * np.ones((1, 1 + n_planes, 1 + n_planes, 1), complex))
        basis = problem.sphere.seen_by(antennas).basis(
            place, antennas, problem.inputs.planes[:n_planes], unknown[:n_planes]
        )
        return near * signals_of(basis, float(angle[0]), angle[1:])

    def resting(rest: FloatArray, antennas: Antennas) -> ComplexArray:
        # all is measured against the direct wave at rest: what mirrors add there is the reflections' own phase
        return received(rest[:, None], antennas, 0)

    # within a sixth of a fringe no direction changes by more than 1e-4
    thinned = Thinned(place_m.shape[1], EACH)
    place_m = place_m[:, thinned.bins]
    here, at_rest = received(place_m, antennas), resting(rest_m, antennas)

    def slope(ahead: ComplexArray, step: float) -> ComplexArray:
        return thinned((ahead - here) / (step * here[:, :1, :1]))

    by_unknown = {}
    for numbers in _together(world):
        ahead = np.zeros_like(z)
        # receivers move each its own rows: one step for the tilts of all
        ahead[list(numbers.values())] = STEP
        there = world.antennas(z + ahead)
        moved = slope(received(place_m, there) * (at_rest / resting(rest_m, there)), STEP)
        for receiver, number in numbers.items():
            if receiver is None:
                by_unknown[number] = moved
            else:
                by_unknown[number] = np.zeros_like(moved)
                by_unknown[number][receiver] = moved[receiver]
    steps = PLACE_STEP_M * np.eye(3)
    by_place = [slope(received(place_m + one[:, None], antennas), PLACE_STEP_M) for one in steps]
    # the place at rest is in the divisor alone: its slope needs the field there and nowhere else
    straight = thinned(here / here[:, :1, :1])
    by_rest = [straight * (at_rest / resting(rest_m + one, antennas) - 1.0) / PLACE_STEP_M for one in steps]
    return AmplitudeSlopes(by_unknown, tuple(by_place), tuple(by_rest))


def _together(world: World) -> list[dict[int | None, int]]:
    """Return the unknowns of the antennas' places by receiver, those together that move different ones; None: all."""
    out: dict[str, dict[int | None, int]] = {}
    for number, one in enumerate(world.unknowns):
        place, _, name = one.key.partition(".")
        if one.key and one.group != "polarization":
            receiver = int(place[9:-1]) - 1 if place.startswith("receiver") else None
            out.setdefault(one.key if receiver is None else name, {})[receiver] = number
    return list(out.values())
