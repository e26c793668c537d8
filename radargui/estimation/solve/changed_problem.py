"""Make from a solution a problem with other breaks, mirrors or bias maps; the rest begins at the solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.estimation.forward.equation_of_motion import EquationDeviation, EquationRows, spans_in_flight
from radargui.estimation.forward.motion_spline import MotionSpline, SplineMotion
from radargui.estimation.forward.parameters import (
    Layout,
    ReceiverConstants,
    lobe_places,
    make_layout,
    polarisation_places,
)
from radargui.estimation.forward.position_map import FINE, PositionBasis, make_basis
from radargui.estimation.solve.initial_problem import INITIAL, usable_bins
from radargui.estimation.solve.lobe_prior import with_lobes_of_walls
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.priors import PRIORS, Prior, flight_prior, make_prior
from radargui.estimation.solve.problem import JointProblem, Start, State
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.gravity import UNKNOWN_DRAG
from radargui.physics.mirrors import MirrorPlane, edges_of, walls_of

# Limits of the jerk's deviation where knots change, m/s^3: new spans start loose enough to follow what the old ones
# could not, and stiff enough to stay in place. Chosen by hand.
_JERK_M_S3 = (3.0, 3.0 * INITIAL.jerk_m_s3)
_MIN_SEEN = 1e-4
"""Share of a map's strongest function below which one is not asked for what the map has said: rounding."""
_OFF_GRAVITY_M_S2 = 0.1
"""First deviation from the equation of flight: what a wall that is not in the model bends a fall by. Chosen by hand."""
_STIFF_M_S2 = 0.01
"""The same where mirrors are new: a fall that bends for a wall hides it, and one found to be stiffer hides what walls
that nothing excludes would do to it (in one drop 64 instead of 99 % inside 2u). Chosen by hand."""


def problem_with_breaks(solution: Solution, motion: SplineMotion) -> Start:
    """Return a solution's problem with other breaks or knots, everything else as the solution has it.

    Parameters
    ----------
    solution
        Converged.
    motion
        With the new breaks.
    """
    problem, spline = solution.problem, motion.spline
    old = problem.layout
    layout = make_layout(replace(old.sizes, breaks=spline.break_s.size))
    others = slice(old.breaks.stop, None)
    now = spline.span_middles()
    # other breaks part other flights
    in_flight = np.zeros(now.size, dtype=bool)
    if old.sizes.flight:
        in_flight = spans_in_flight(motion, problem.released_s, problem.gravity_m_s2)
    rows = EquationRows.of(spline, in_flight)
    jerk_sd = np.clip(np.interp(now, *_log_jerk_sd(solution)), *np.log(_JERK_M_S3))
    # breaks stand first: everything behind them moves by their number
    shift = layout.breaks.stop - old.breaks.stop
    prior = Prior(
        np.concatenate([spline.break_s, problem.prior.mean[others]]),
        np.concatenate([np.full(spline.break_s.size, PRIORS.settled_break_s), problem.prior.sd[others]]),
        [replace(group, index=group.index + shift) for group in problem.prior.groups],
    )
    changed = replace(
        problem,
        spline=spline,
        layout=layout,
        prior=prior,
        in_flight=in_flight,
        equation_sd=np.where(rows.is_flight, _OFF_GRAVITY_M_S2, np.exp(jerk_sd[rows.span])),
        use=usable_bins(problem.bins, spline.break_s),
    )
    return Start(changed, State(motion.coefficients, np.concatenate([spline.break_s, solution.state.theta[others]])))


def problem_with_flights(solution: Solution, off_m_s2: float | None = None) -> Start | None:
    """Return a solution's problem with the equation of free flight where it flies; None where nothing does.

    Its deviation begins at `off_m_s2`; None: as far off as the motion is.
    """
    problem, theta = solution.problem, solution.state.theta
    motion = SplineMotion(solution.at.spline, solution.state.coefficients)
    in_flight = spans_in_flight(motion, problem.released_s, problem.gravity_m_s2)
    if not in_flight.any():
        return None
    old, rows = problem.layout, EquationRows.of(motion.spline, in_flight)
    # what does not fly tells nothing of the antennas: motion and antennas trade freely there
    unknowns = problem.inputs.setup
    layout = make_layout(replace(old.sizes, flight=1, setup=0 if unknowns is None else unknowns.size))
    new_theta, mean, sd = np.zeros(layout.size), np.zeros(layout.size), np.ones(layout.size)
    source, target = carried_places(old, layout)
    for new, was in ((new_theta, theta), (mean, problem.prior.mean), (sd, problem.prior.sd)):
        new[target] = was[source]
    mean[layout.flight], sd[layout.flight] = flight_prior(unknowns, problem.gravity_m_s2)
    new_theta[layout.flight] = mean[layout.flight]
    if unknowns is not None:
        sd[layout.setup] = unknowns.deviation
    place = np.zeros(old.size, dtype=np.intp)
    place[source] = target
    groups = [replace(group, index=place[group.index]) for group in problem.prior.groups]
    jerk_sd = np.exp(_log_jerk_sd(solution)[1])
    drag, n_breaks = UNKNOWN_DRAG if unknowns is None else unknowns.drag, motion.spline.break_s.size
    if off_m_s2 is None:
        # antennas that are off bend it by more than a wall: held straight at once, signals lead it astray
        bent = EquationDeviation.of(rows, motion.coefficients, mean[layout.flight], drag.slow_m_s, n_breaks)
        off_m_s2 = max(_OFF_GRAVITY_M_S2, float(np.sqrt((bent.value[rows.is_flight] ** 2).mean())))
    changed = replace(
        problem,
        spline=motion.spline,
        layout=layout,
        prior=Prior(mean, sd, groups),
        in_flight=in_flight,
        equation_sd=np.where(rows.is_flight, off_m_s2, jerk_sd[rows.span]),
        slow_m_s=drag.slow_m_s,
    )
    return Start(changed, State(solution.state.coefficients, new_theta))


def span_jerk_sd(problem: JointProblem, spline: MotionSpline) -> FloatArray:
    """Return the jerk's deviation in each span, (n_spans,); in flight that of accelerations of different knots."""
    rows, (_, _, length) = EquationRows.of(spline, problem.in_flight), spline.jerk()
    out = np.empty(length.size)
    out[rows.span] = np.where(rows.is_flight, np.sqrt(2.0) / length[rows.span], 1.0) * problem.equation_sd
    return out


def _log_jerk_sd(solution: Solution) -> tuple[FloatArray, FloatArray]:
    # in logarithms: deviations differ by five orders of magnitude between a fall and a contact
    middle = solution.at.spline.span_middles()
    return middle, np.log(span_jerk_sd(solution.problem, solution.at.spline))


def problem_with_mirrors(
    solution: Solution, planes: tuple[MirrorPlane, ...], bias: PositionBasis | None = None
) -> Start:
    """Return a solution's problem with other mirrors or other functions for the bias.

    Everything else starts from the solution. New mirrors and new bias maps start at zero; with more mirrors all bias
    maps do. The deviations of all maps and mirrors start again.

    Parameters
    ----------
    solution
        Converged.
    planes
        The mirrors in the solution's order, more or fewer. New ones stand last, or first if the last one stays the
        last.
    bias
        Functions of the bias maps; None keeps them.
    """
    before = solution.problem
    problem, theta = mirrors_changed(before, solution.state.theta, planes, bias)
    problem = replace(problem, spline=solution.at.spline, equation_sd=stiff_equation_sd(solution))
    # other functions of position, or other images of the antennas
    if bias is not None or problem.sphere is not None:
        problem = problem.at_places(positions_at_bins(solution), theta)
    return Start(problem, State(solution.state.coefficients, theta))


def problem_with_fine_maps(start: Start, place: FloatArray, visited: BoolArray) -> Start:
    """Return a start whose maps have all functions of their processes, with the same values where the body went.

    Parameters
    ----------
    start
        To change.
    place
        At the bins, shape (3, n_bins).
    visited
        True for bins after the rest, shape (n_bins,).
    """
    problem, theta, old = start.problem, start.state.theta, start.problem.layout
    before, there = (problem.bias_basis, problem.amplitude_basis), place[:, visited]
    bias, amplitude = after = [make_basis(there, one.length_m, FINE) for one in before]
    # the smallest coefficients that say the same: the data have not seen the weakest functions
    by_bias, by_amplitude = (
        np.linalg.lstsq(new(there), was(there), rcond=_MIN_SEEN)[0] for was, new in zip(before, after, strict=True)
    )
    layout = make_layout(replace(old.sizes, bias=bias.size, amplitude_map=amplitude.size))
    carried = np.zeros((layout.size, old.size))
    source, target = carried_places(old, layout, bias=False)
    carried[target, source] = 1.0
    for was, now in zip(old.receivers, layout.receivers, strict=True):
        carried[now.bias_i, was.bias_i] = carried[now.bias_q, was.bias_q] = by_bias
        carried[now.amplitude_map, was.amplitude_map] = by_amplitude
    # every coefficient has the deviation, and belongs to the group, of those it comes from
    comes_from = carried != 0.0
    groups = [replace(one, index=np.flatnonzero(comes_from[:, one.index].any(axis=1))) for one in problem.prior.groups]
    prior = Prior(carried @ problem.prior.mean, problem.prior.sd[np.argmax(comes_from, axis=1)], groups)
    finer = replace(problem, layout=layout, prior=prior, bias_basis=bias, amplitude_basis=amplitude)
    theta = carried @ theta
    return Start(finer.at_places(place, theta), State(start.state.coefficients, theta))


def stiff_equation_sd(solution: Solution) -> FloatArray:
    """Return the deviations of the equation's rows while a mirror is sought, (n_rows,): flights do not bend."""
    sd = solution.problem.equation_sd
    return np.where(solution.at.equation.rows.is_flight, _STIFF_M_S2, sd)


def mirrors_changed(
    before: JointProblem, theta: FloatArray, planes: tuple[MirrorPlane, ...], bias: PositionBasis | None = None
) -> tuple[JointProblem, FloatArray]:
    """Return a problem with other mirrors or other functions for the bias, and theta; see `problem_with_mirrors`."""
    old = before.layout
    n_bias = old.sizes.bias if bias is None else bias.size
    n_edges = 0 if edges_of(planes) is None else 1
    n_walls = len(walls_of(planes))
    layout = make_layout(replace(old.sizes, mirrors=len(planes), walls=n_walls, bias=n_bias, edges=n_edges))
    # maps that explain what a new mirror would hold it down: kept, a wall gained 32 in ln E and 0.47 mm stayed; started
    # at zero it gained 149 and 0.09 mm was left
    fewer, was_planes = len(planes) <= old.sizes.mirrors, before.inputs.planes
    last_stays = bool(planes and was_planes) and planes[-1] is was_planes[-1]
    source, target = carried_places(old, layout, bias=bias is None and fewer, last=last_stays)
    mean, sd = before.prior.mean, before.prior.sd
    # priors as at the start: what was re-estimated without the mirror explains what the mirror shall
    means = [ReceiverConstants(*mean[own.constants]) for own in old.receivers]
    prior = make_prior(layout, planes, mean[old.breaks], means)
    # a new mirror starts at nothing, and its evidence counts from there
    new_theta = np.zeros(layout.size)
    lobes = lobe_places(layout)
    for places in (lobes, layout.exchange, layout.edges):
        new_theta[places] = prior.mean[places]
    new_theta[target] = theta[source]
    # a plane that was put elsewhere counts from there
    moved = [all(new is not was for was in was_planes) for new in planes]
    new_theta[layout.planes].reshape(-1, 3)[moved] = 0.0
    middle = before.bias_basis.centre.mean(axis=1)
    prior = with_lobes_of_walls(prior, layout, new_theta, planes, before.inputs.antennas, middle)
    fresh = np.setdiff1d(lobes, target)
    new_theta[fresh] = prior.mean[fresh]
    for was, now in zip(old.receivers, layout.receivers, strict=True):
        of_hardware = (slice(one.log_gain, one.harmonics.stop) for one in (was, now))
        a, b = of_hardware
        prior.mean[b], prior.sd[b] = mean[a], sd[a]
    for values, known in ((prior.mean, mean), (prior.sd, sd)):
        values[polarisation_places(layout)] = known[polarisation_places(old)]
        values[layout.flight], values[layout.setup] = known[old.flight], known[old.setup]
    problem = replace(
        before,
        layout=layout,
        prior=prior,
        inputs=replace(before.inputs, planes=planes),
        bias_basis=before.bias_basis if bias is None else bias,
    )
    return problem, new_theta


def positions_at_bins(solution: Solution) -> FloatArray:
    """Return the positions at the bins' mean times, shape (3, n_bins)."""
    return np.asarray((solution.at.design @ solution.state.coefficients + solution.problem.inputs.release_m).T)


def carried_places(old: Layout, new: Layout, *, bias: bool = True, last: bool = False) -> tuple[IntArray, IntArray]:
    """Return places in the old layout and the same in a new one with more or fewer mirrors, both of shape (n,).

    Parameters
    ----------
    old, new
        Layouts.
    bias
        Whether the coefficients of the bias maps mean the same in both.
    last
        Whether the last mirrors are the same; else the first are.
    """
    pairs = [(old.breaks, new.breaks), (old.flight, new.flight), (old.planes, new.planes)]
    pairs += [
        (old.transmitter_reflection, new.transmitter_reflection),
        (old.exchange, new.exchange),
        (old.edges, new.edges),
        (old.transmitter_lobe, new.transmitter_lobe),
        (old.polarization, new.polarization),
        (old.crosstalk, new.crosstalk),
        (old.setup, new.setup),
    ]
    for was, now in zip(old.receivers, new.receivers, strict=True):
        pairs += [
            (was.constants, now.constants),
            (was.harmonics, now.harmonics),
            (was.amplitude_map, now.amplitude_map),
        ]
        if bias:
            pairs += [(was.bias_i, now.bias_i), (was.bias_q, now.bias_q)]
        pairs += [
            (was.receiver_reflection, now.receiver_reflection),
            (was.receiver_lobe, now.receiver_lobe),
            (was.double_reflection, now.double_reflection),
            (was.polarization, now.polarization),
        ]
        pairs += [(was.drift_i, now.drift_i), (was.drift_q, now.drift_q)]
    shared = [(a, b, min(a.stop - a.start, b.stop - b.start)) for a, b in pairs]
    source, target = (
        np.concatenate([(one.stop - count if last else one.start) + np.arange(count) for one, count in side])
        for side in ([(a, count) for a, _, count in shared], [(b, count) for _, b, count in shared])
    )
    return source, target
