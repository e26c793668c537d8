"""Compute how a solution follows small changes of the setup: antennas, release, wavelength, sphere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.forward.sphere import PolarisedSphere, SphereFactors, polarised_sphere
from radargui.estimation.posterior.floor_slope import floor_slope
from radargui.estimation.solve.assemble import DataSums, assemble
from radargui.estimation.solve.break_velocities import one_sided_slopes
from radargui.estimation.solve.changed_problem import stiff_equation_sd
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.problem import BINS_TOGETHER, signals_in_parts
from radargui.model.arrays import FloatArray, pieces
from radargui.model.assumed import OF_SPHERE, SUPPOSED_POLARIZATIONS_DEG, SUPPOSED_TURNS_DEG, UncertainInput
from radargui.model.setup import Setup
from radargui.physics.path_length import Antennas, place_antennas

STEP = 0.01
"""Share of an uncertainty by which an input is moved: the response is linear, half a degree of an antenna is not."""


@dataclass(frozen=True, slots=True, eq=False)
class OtherInputs:
    """Other values that the setup could state.

    Attributes
    ----------
    antennas, release_m, wavenumber
        Geometry; 1/m.
    sphere
        Sphere that replaces the solution's; None: it stays as it is.
    body
        If the solution treats the sphere as a point: the factors by which a sphere would multiply the paths.
    """

    antennas: Antennas
    release_m: FloatArray
    wavenumber: float
    sphere: PolarisedSphere | None = None
    body: PolarisedSphere | None = None


def moved_inputs(setup: Setup, one: UncertainInput) -> OtherInputs:
    """Return the inputs with an uncertain one moved by `STEP` of its uncertainty."""
    other = one.moved(setup, STEP)
    sphere, like = polarised_sphere(other), polarised_sphere(setup)
    # what an antenna elsewhere changes in the sphere's factors is of second order
    turned = None if one.key not in OF_SPHERE or sphere is None or like is None else replace(like, sphere=sphere.sphere)
    release, wavenumber = np.asarray(other.tracer.release_position_m), 2.0 * np.pi / other.radar.wavelength_m
    return OtherInputs(place_antennas(other), release, wavenumber, turned)


def possible_spheres(setup: Setup) -> list[OtherInputs]:
    """Return the inputs with a conducting sphere for the point, antennas polarised in some ways."""
    release, wavenumber = np.asarray(setup.tracer.release_position_m), 2.0 * np.pi / setup.radar.wavelength_m
    out = []
    for angle in SUPPOSED_POLARIZATIONS_DEG:
        turned = setup.transmitter.model_copy(update={"polarization_deg": angle})
        body = polarised_sphere(setup.model_copy(update={"transmitter": turned}))
        if body is None:
            continue
        receivers = np.arange(body.angle_rad.size) > 0
        for turn in SUPPOSED_TURNS_DEG:
            other = replace(body, angle_rad=body.angle_rad + np.radians(turn) * receivers)
            out.append(OtherInputs(place_antennas(setup), release, wavenumber, body=other))
    return out


@dataclass(frozen=True, slots=True, eq=False)
class InputResponse:
    """The response to one input moved by its uncertainty.

    Attributes
    ----------
    slope
        Change of the slope of -ln L, the motion first, x, y and z interleaved, shape (3 size + n_global,).
    moved_m
        Shift of the motion at some times, shape (3, n).
    before_m_s, after_m_s
        Changes of the velocities at the breaks, shape (n_breaks, 3).
    floor_slope
        Change of the slope of the floor that reflects, shape (2,); zero where none was found.
    bias
        Change of the coefficients of each receiver's bias maps, root mean square in amplitudes, shape (n_receivers,).
    """

    slope: FloatArray
    moved_m: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    floor_slope: FloatArray
    bias: FloatArray


def input_responses(
    solution: Solution, sums: DataSums, others: Sequence[OtherInputs], time_s: FloatArray
) -> tuple[InputResponse, ...]:
    """Return the response to each of some inputs that differ by `STEP` of their uncertainty.

    A solution minimises -ln L(x, a) - ln prior over all unknowns x for inputs a. With m the model and J = dm/dx, the
    slope J^T W (m(a + da) - m(a)) moves it by -H^-1 times that: motion, mirrors and maps follow together, as in an
    estimate with those inputs.

    Parameters
    ----------
    solution, sums
        The converged solution, and the sums over the data there.
    others
        Inputs moved by `STEP` of their uncertainty.
    time_s
        Times at which the shift is wanted, shape (n,).
    """
    if not others:
        return ()
    changes = np.stack([_change(solution, other) for other in others], axis=2)
    slopes = _slopes(solution, changes)
    spline, release = solution.at.spline, solution.problem.inputs.release_m
    bin_s, layout = solution.problem.bins.time_s, solution.problem.layout
    # a break that moves carries the knots of both flights along
    by_breaks = spline.break_slopes(bin_s, solution.state.coefficients)
    # where an input is wrong flights bend, and their deviations would follow
    loose = replace(solution.problem, equation_sd=stiff_equation_sd(solution))
    normal = assemble(loose, solution.state, solution.at, sums).factor()
    sides, floor, out = one_sided_slopes(spline), floor_slope(solution), []
    for slope, other, follows in zip(slopes.T, others, normal.solve(-slopes).T, strict=True):
        coefficients, rest = follows[: normal.n_motion].reshape(-1, 3), follows[normal.n_motion :]
        along = solution.at.design @ coefficients + (by_breaks @ rest[layout.breaks]).reshape(-1, 3)
        # a release elsewhere carries the whole motion along, before the samples turn it back
        along = along + (other.release_m - release) / STEP
        moved = np.array([np.interp(time_s, bin_s, row) for row in along.T])
        before, after = (side @ coefficients for side in sides)
        leans = np.zeros(2) if floor is None else floor.by_global @ rest[floor.places]
        bias = np.array([np.sqrt(np.mean(rest[own.bias_i.start : own.bias_q.stop] ** 2)) for own in layout.receivers])
        out.append(InputResponse(slope, moved, before, after, leans, bias))
    return tuple(out)


def _change(solution: Solution, other: OtherInputs) -> FloatArray:
    """Return by how much the model changes with the inputs at the same motion against the release, (n_channels, n)."""
    problem, state = solution.problem, solution.state
    inputs = replace(problem.inputs, antennas=other.antennas, release_m=other.release_m, wavenumber=other.wavenumber)
    # the motion counts from the release: where that is wrong the whole motion is shifted, and bent by the geometry
    node_m = solution.at.node_m + (other.release_m - problem.inputs.release_m)[:, None, None, None]
    place = node_m.mean(axis=(1, 2))
    mirrors = state.theta[problem.layout.mirrors]
    if other.sphere is not None:
        fields = other.sphere.fields(place, other.antennas, other.release_m, inputs.planes, mirrors)
        inputs = replace(inputs, sphere=fields)
    if other.body is not None:
        body = other.body
        fields = body.fields(place, other.antennas, other.release_m, inputs.planes, mirrors)
        angles = body.angle_rad
        factors = [fields.factors(n, angles[0], angles[1 + n]) for n in range(problem.n_receivers)]
        inputs = replace(inputs, body=tuple(_weakened(own) for own in factors))
    # same unknowns, other world: what the minimum then has to follow
    signals, _, _ = signals_in_parts(replace(problem, inputs=inputs), state.theta, node_m)
    return np.concatenate([a.value - b.value for a, b in zip(signals, solution.at.signals, strict=True)]) / STEP


def _weakened(factors: SphereFactors) -> SphereFactors:
    """Return the factors of a sphere of which only `STEP` is there."""
    # a hundredth of its phase and of its loss: linear where a whole sphere is not
    return SphereFactors(np.exp(STEP * np.log(factors.direct)), 1.0 + STEP * (factors.mirrored - 1.0))


def _slopes(solution: Solution, changes: FloatArray) -> FloatArray:
    """Return J^T W of changes of the model, (n_channels, n_bins, n), shape (3 size + n_global, n)."""
    problem, state, at = solution.problem, solution.state, solution.at
    layout, inputs, n_bins = problem.layout, problem.inputs, problem.bins.n_bins
    pull, by_global = np.zeros((n_bins, 3, changes.shape[2])), np.zeros((layout.size, changes.shape[2]))
    for part in pieces(n_bins, BINS_TOGETHER):
        here = inputs.of_bins(part)
        for receiver, own in enumerate(layout.receivers):
            pair = slice(2 * receiver, 2 * receiver + 2)
            node_m, excess = at.node_m[:, pair, :, part], at.excess[pair, part]
            slopes = receiver_slopes(node_m, state.theta, layout, here, receiver, excess)
            weighed = at.weight[pair, part][:, :, None] * changes[pair, part]
            pull[part] += np.einsum("can,cnk->nak", slopes.by_position, weighed)
            by_global[layout.shared] += np.einsum("cnp,cnk->pk", slopes.by_shared, weighed)
            by_global[own.without_drift] += np.einsum("cnp,cnk->pk", slopes.by_own, weighed)
            # slow noise is each channel's own, and linear: its functions are its slopes
            for channel, drift in enumerate((own.drift_i, own.drift_q)):
                by_global[drift] += here.drift[2 * receiver + channel].T @ weighed[channel]
    flat = pull.reshape(3 * n_bins, -1)
    breaks = at.spline.break_slopes(problem.bins.time_s, state.coefficients)
    by_global[layout.breaks] += breaks.T @ flat
    return np.concatenate([at.series.rows().of_place.T @ flat, by_global])
