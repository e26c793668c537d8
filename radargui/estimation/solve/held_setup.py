"""Read the posterior of the setup's unknowns, and make the solution that holds them as constants."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.estimation.forward.parameters import make_layout
from radargui.estimation.solve.changed_problem import carried_places
from radargui.estimation.solve.minimise import Solution, solved_at
from radargui.estimation.solve.priors import Prior
from radargui.estimation.solve.problem import JointProblem, Start, State
from radargui.model.arrays import FloatArray
from radargui.model.setup_posterior import SetupLikelihood, SetupPosterior
from radargui.physics.setup_unknowns import SetupUnknowns


def setup_posterior(solution: Solution) -> SetupPosterior | None:
    """Return what a solution says of the setup; None where nothing of it is unknown."""
    layout, unknowns = solution.problem.layout, solution.problem.inputs.setup
    if unknowns is None or not layout.sizes.setup:
        return None
    # g too: what the others say must not rest on the g that this run is told of once more
    places = np.r_[layout.setup, layout.flight.start + 2]
    covariance, prior = solution.normal.global_covariance[np.ix_(places, places)], solution.problem.prior
    off, n = (solution.state.theta - prior.mean)[places], unknowns.size
    return SetupPosterior(
        unknowns.inputs,
        unknowns.deviation,
        off[:n],
        covariance[:n, :n],
        SetupLikelihood.of_posterior(off, covariance, prior.sd[places], n),
    )


def with_setup_moved(solution: Solution, unknowns: SetupUnknowns, by: FloatArray) -> Start:
    """Return a held solution's problem with antennas, release and wave moved by so many u, shape (n,), to begin at."""
    inputs = solution.problem.inputs
    moved = replace(
        inputs,
        antennas=unknowns.antennas(inputs.antennas, by),
        release_m=inputs.release_m + unknowns.by_release @ by,
        wavenumber=inputs.wavenumber * float(np.exp(unknowns.by_log_wavenumber @ by)),
    )
    return Start(replace(solution.problem, inputs=moved), solution.state)


def with_antennas_of(solution: Solution, other: Solution) -> Start:
    """Return a held solution's problem with the antennas, release and wave of another, to begin at."""
    inputs, of = solution.problem.inputs, other.problem.inputs
    inputs = replace(inputs, antennas=of.antennas, release_m=of.release_m, wavenumber=of.wavenumber)
    return Start(replace(solution.problem, inputs=inputs), solution.state)


def with_setup_held(solution: Solution) -> Solution:
    """Return a solution with antennas, release and wave held where it has found them."""
    problem, state = _held(solution.problem, solution.state)
    if problem is solution.problem:
        return solution
    return replace(solved_at(Start(problem, state)), settled=solution.settled, damping=solution.damping)


def moved_with_setup_held(held: Solution, full: JointProblem, state: State) -> Solution:
    """Return a held solution moved to a state of the problem in which the setup was unknown."""
    problem, state = _held(full, state)
    return replace(held, problem=problem, state=state)


def _held(problem: JointProblem, state: State) -> tuple[JointProblem, State]:
    old = problem.layout
    if not old.sizes.setup:
        return problem, state
    placed = problem.placed(state.theta)
    layout = make_layout(replace(old.sizes, setup=0))
    source, target = carried_places(old, layout)
    theta, mean, sd = np.zeros((3, layout.size))
    for new, was in ((theta, state.theta), (mean, problem.prior.mean), (sd, problem.prior.sd)):
        new[target] = was[source]
    place = np.zeros(old.size, dtype=np.intp)
    place[source] = target
    groups = [replace(one, index=place[one.index]) for one in problem.prior.groups]
    inputs = replace(placed.inputs, setup=None, setup_at=None)
    return replace(placed, layout=layout, prior=Prior(mean, sd, groups), inputs=inputs), State(
        state.coefficients, theta
    )
