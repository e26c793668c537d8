"""Search walls that the recordings of a calibration share, with antennas and motions nearly known."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import compress

import numpy as np

from radargui.calibration.fit import Fit, Settled, crew, settling
from radargui.calibration.likelihood import Likelihood
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.estimation.select.wall_grid import (
    WALLS,
    DirectWave,
    evidence_of,
    images_of,
    scattered_over,
    stiffened,
    upright_planes,
    wall_grid,
    wall_towards,
)
from radargui.estimation.select.walls import peaks
from radargui.estimation.solve.changed_problem import carried_places
from radargui.estimation.solve.lobe_prior import main_lobes
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError, SolveError
from radargui.physics.mirrors import MirrorPlane

MAX_WALLS = 2
"""As many as are sought; what is left is the maps'."""
SEARCHES, CARRIED, CARRIED_AGAIN = 4, 4, 3
"""The grid, then finer around what was found, for antennas bent by a wall hide where it is; places fitted of each."""
SHARES = np.geomspace(0.5, 2.0, 19)
"""Distances of the finer grid over that of the wall found: one that is wrong by half still gains."""
CONVINCING = 300.0
"""Gain in ln E at which a wall is kept. What the floor's model leaves of a motion that goes sideways gave false walls
up to 174 (and made distances 10 mm wrong), true walls of a few per cent more than 1800. Chosen by hand at 36 dB."""
WORTHWHILE = 100.0
"""In ln E, of another search: less moves the antennas by less than a tenth of their u."""
PROMISING = 100.0
"""Linearised gain from which a place is fitted: three rooms with a wall had 5700 to 8200, and once it was found 2000,
2800 and -30; a room without one had -28."""
AGREEING = 1.1
"""Most that the Birge ratio may grow by a wall: true walls took it from 2.5 to 1.3, 8.1 to 4.9 and 11.8 to 5.3, false
ones from 1.25 to 2.5 and 4.6."""
MAX_COMPARED = 3
"""Recordings in which walls are sought."""
MAX_BEHIND, LATE = (1000.0, 300.0, 50.0, np.inf), 500.0
"""In ln E, behind the best of the places after each renewal: in three rooms those that won were the best after the
first, and led by 1200 to 10 000 after the second. From then on a wall without which ln E is higher is none."""
CLEAR_M = 0.02
"""No wall is nearer to the sphere's centre."""
TOGETHER = 20
"""Planes looked at together: they stay in memory."""


def with_walls(base: Settled, normal: FloatArray) -> Settled:
    """Return the fit with the walls that its recordings ask for.

    As the joint estimate seeks them (method 4, Walls): the evidence of each place of a grid with everything else
    marginalised, the best few fitted, the best kept where it convinces.

    Parameters
    ----------
    base
        Without walls.
    normal
        Upward normal of the floor, shape (3,).
    """
    best = base
    for _ in range(MAX_WALLS):
        better = _one_more(best, normal)
        if better is None or better.log_evidence < best.log_evidence + CONVINCING:
            break
        # a wall that is there lets the recordings agree; one that only lends freedom sets them against each other
        if better.found.birge() > AGREEING * best.found.birge():
            break
        best = better
    return best


def some_of(likelihoods: Sequence[Likelihood]) -> list[int]:
    """Return the numbers of a few of the recordings: where walls are, these say as well as all."""
    numbers = [n for n, one in enumerate(likelihoods) if isinstance(one, SignalLikelihood)]
    if len(likelihoods) <= MAX_COMPARED or len(numbers) < MAX_COMPARED:
        return list(range(len(likelihoods)))
    return numbers[:: len(numbers) // MAX_COMPARED][:MAX_COMPARED]


def n_mirrors(settled: Settled) -> int:
    """Return the most mirrors that a recording has."""
    return max((len(one.problem.inputs.planes) for one, _, _ in _sampled(settled)), default=0)


def planes_of(settled: Settled, first: int, normal: FloatArray) -> tuple[MirrorPlane, ...]:
    """Return planes where the mirrors from a number on are, upright, the mean of the recordings'."""
    walls, middle = list[MirrorPlane](), _middle(settled)
    for k in range(first, n_mirrors(settled)):
        angle, away = _place_of(settled, k, middle, normal)
        walls += upright_planes(middle, normal, np.array([angle]), np.array([away]))
    return tuple(walls)


def _one_more(base: Settled, normal: FloatArray) -> Settled | None:
    if not _sampled(base):
        return None
    middle = _middle(base)
    azimuth, distance = wall_grid()
    best, at = None, base
    for number in range(SEARCHES):
        planes = upright_planes(middle, normal, azimuth, distance)
        gains = np.where(_clear(at, planes), linearised_gains(at, planes), -np.inf)
        # a place costs a fit of all recordings
        if gains.max() < PROMISING:
            return best
        gains = gains.reshape(azimuth.size, -1)
        places = peaks(gains, around=number == 0)[: CARRIED if number == 0 else CARRIED_AGAIN]
        before = best.log_evidence if best is not None else -np.inf
        for trial in _trials(at, [(planes[k],) for k in places]):
            if best is None or trial.log_evidence > best.log_evidence:
                best = trial
        if best is None or best.log_evidence < base.log_evidence + 0.5 * CONVINCING:
            return None
        if best.log_evidence < before + WORTHWHILE:
            break
        # what the wall has straightened stays straight: from there its place shows better
        at = _without_last(best, base)
        angle, away = _place_of(best, -1, middle, normal)
        azimuth = angle + np.radians(WALLS.fine_deg)
        distance = np.maximum(away * SHARES, WALLS.nearest_m)
    return best


def _without_last(settled: Settled, base: Settled) -> Settled:
    """Return a fit without its last mirror, with the maps of one that never had it: no minimum, a place to go on."""
    found, likelihoods, states = settled.found, [], []
    for one, bare, own in zip(settled.likelihoods, base.likelihoods, found.own, strict=True):
        if isinstance(one, SignalLikelihood) and isinstance(bare, SignalLikelihood):
            place, there = carried_places(bare.problem.layout, one.problem.layout)
            theta = np.zeros(bare.theta.size)
            # what both have is carried over; the wall's own and the maps that grew with it are left behind
            theta[place] = one.theta_at(own)[there]
            one, own = bare.with_problem(bare.problem, theta, own)
        likelihoods.append(one)
        states.append(own)
    locals_ = tuple(one.at(found.world, found.z, own) for one, own in zip(likelihoods, states, strict=True))
    return Settled(replace(found, own=tuple(states), locals_=locals_), tuple(likelihoods))


def _trials(base: Settled, walls: Sequence[tuple[MirrorPlane, ...]]) -> list[Settled]:
    """Return the fits with walls, less those that are left behind on the way there (`MAX_BEHIND`)."""
    going = []
    for planes in walls:
        pairs = zip(base.likelihoods, base.found.own, strict=True)
        likelihoods, own = zip(*(one.with_mirrors(planes, state) for one, state in pairs), strict=True)
        going.append(settling(base.found, likelihoods, own))
    there: list[Settled] = []
    for behind in MAX_BEHIND:
        there, left = [], going
        going = []
        for one in left:
            with suppress(ProcessingError, SolveError):
                there.append(next(one))
                going.append(one)
        best = max((one.log_evidence for one in there), default=-np.inf)
        if behind < LATE and best < base.log_evidence:
            return []
        kept = [one.log_evidence > best - behind for one in there]
        there, going = list(compress(there, kept)), list(compress(going, kept))
    return there


def _sampled(base: Settled) -> list[tuple[SignalLikelihood, FloatArray, int]]:
    rows = enumerate(zip(base.likelihoods, base.found.own, strict=True))
    return [(one, own, n) for n, (one, own) in rows if isinstance(one, SignalLikelihood)]


def _places(base: Settled) -> list[FloatArray]:
    """Return where the sphere goes in each recording by its samples, shape (3, n_bins)."""
    return [one.sampled(base.found.world, base.found.z, own).place_m for one, own, _ in _sampled(base)]


def _middle(base: Settled) -> FloatArray:
    """Return the middle of the motions, shape (3,); each counts alike, however long it is."""
    return np.asarray(np.mean([place.mean(axis=1) for place in _places(base)], axis=0))


def _place_of(settled: Settled, number: int, middle_m: FloatArray, normal: FloatArray) -> tuple[float, float]:
    """Return azimuth and distance of a mirror, the mean of the recordings'."""
    outward = []
    for one, own, _ in _sampled(settled):
        unknown = one.problem.layout.plane_unknowns(one.theta_at(own))[number]
        outward.append(one.problem.inputs.planes[number].image(middle_m, unknown) - middle_m)
    # images, not angles: a mean of azimuths would break where they pass a full turn
    return wall_towards(np.mean(outward, axis=0), normal)


def _clear(base: Settled, planes: Sequence[MirrorPlane]) -> BoolArray:
    """Return which planes no motion comes near, shape (n_planes,): the sphere does not go through walls."""
    everywhere = np.concatenate(_places(base), axis=1)
    return np.array(
        [float((plane.normal @ everywhere).min() - plane.normal @ plane.foot_m) > CLEAR_M for plane in planes]
    )


def linearised_gains(base: Settled, planes: list[MirrorPlane]) -> FloatArray:
    """Return the linearised log evidence of each plane as one more wall, shape (n_planes,), summed over recordings."""
    tasks = [(base.found, *one, planes) for one in _sampled(base)]
    return np.asarray(sum(crew().each(_gains_of_one, tasks, crew().shares.round_done)))


def _gains_of_one(
    found: Fit, likelihood: SignalLikelihood, own: FloatArray, number: int, planes: list[MirrorPlane]
) -> FloatArray:
    search = _LinearisedSearch(found, likelihood, own, number)
    parts = [search.gains(planes[first : first + TOGETHER]) for first in range(0, len(planes), TOGETHER)]
    return np.concatenate(parts)


class _LinearisedSearch:
    """What one more mirror would explain of a recording, everything else marginalised."""

    def __init__(self, found: Fit, likelihood: SignalLikelihood, own: FloatArray, number: int) -> None:
        world, z, free = found.world, found.z, ~found.held
        # maps that have grown to explain a wall would hide it
        stiff, own = likelihood.with_prior(stiffened(likelihood.problem).prior, own)
        self.at = stiff.sampled(world, z, own)
        n_receivers = self.at.problem.n_receivers
        self.parts = stiff.rows(world, z, self.at)
        self.local = stiff.local(self.at, self.parts, z.size, own)
        normal, slope, self.back = self.local.reduced(0.0)
        # all recordings, this one with its stiffened maps in place of those it has
        others, others_slope = found.information(but=number)
        total = others + normal + np.eye(z.size)
        self.free, self.inverse = free, np.linalg.inv(total[np.ix_(free, free)])
        self.shared_slope = (others_slope + slope + z)[free]
        inputs, layout = self.at.problem.inputs, self.at.problem.layout
        lobes = main_lobes(layout, self.at.theta)
        self.waves = [
            DirectWave.of(self.at.node_m[:, 2 * n : 2 * n + 2], self.at.waves.of(n), inputs, lobes[[0, 1 + n]])
            for n in range(n_receivers)
        ]

    def gains(self, planes: list[MirrorPlane]) -> FloatArray:
        """Return the evidence of T and R of each plane, shape (n_planes,)."""
        at, n_planes, n_shared = self.at, len(planes), len(self.local.slope)
        n_new = 2 + 2 * at.problem.n_receivers
        slope, a = np.zeros((n_planes, n_new)), np.zeros((n_planes, n_new, n_new))
        to_all = np.zeros((n_planes, n_new, n_shared + len(self.local.inner_slope)))
        images = images_of(at.problem.inputs.antennas, planes)
        scattered = scattered_over(at.problem, at.theta, at.place_m, planes)
        for n, (part, wave) in enumerate(zip(self.parts, self.waves, strict=True)):
            sphere = None if scattered is None else [leg[:, n] for leg in scattered]
            j = wave.columns((images[0], images[1 + n]), sphere)
            weighed = (j * at.weight[2 * n : 2 * n + 2]).reshape(n_planes, 4, -1)
            columns = np.r_[0:2, 2 + 2 * n : 4 + 2 * n]
            slope[:, columns] += weighed @ at.residual[2 * n : 2 * n + 2].ravel()
            a[:, columns[:, None], columns] += weighed @ j.reshape(weighed.shape).transpose(0, 2, 1)
            to_all[:, columns[:, None], part.index] += weighed @ part.rows.reshape(-1, part.index.size)
        # Schur complements: the recording's own taken out, then what all share
        own = to_all[:, :, n_shared:]
        # tables and walls reflect about so much: without a prior a plane that nothing sees could be any
        a += np.eye(n_new) / WALLS.reflection**2
        solved = np.linalg.solve(self.local.inner, own.reshape(-1, own.shape[2]).T).T.reshape(own.shape)
        a -= own @ solved.transpose(0, 2, 1)
        slope = slope - own @ self.back[:, -1]
        shared = (to_all[:, :, :n_shared] - own @ self.back[:, :-1])[:, :, self.free]
        a -= shared @ self.inverse @ shared.transpose(0, 2, 1)
        slope = slope - shared @ (self.inverse @ self.shared_slope)
        return evidence_of(slope, a, WALLS.reflection)
