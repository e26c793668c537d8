"""Make the initial problem: motion and constants as found before; maps, mirrors and drift at zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.bins import BinnedData, Bins
from radargui.estimation.forward.motion_spline import SplineMotion, make_spline
from radargui.estimation.forward.parameters import (
    ReceiverConstants,
    Sizes,
    lobe_places,
    make_layout,
    polarisation_places,
)
from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.forward.signal_model import ModelInputs
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.solve.normal import solve_band
from radargui.estimation.solve.priors import make_prior, with_known_front_ends, with_polarisation
from radargui.estimation.solve.problem import JointProblem, Start, State
from radargui.model.arrays import BoolArray, FloatArray
from radargui.physics.mirrors import MirrorPlane, edges_of, walls_of


@dataclass(frozen=True, slots=True)
class InitialSettings:
    """Initial values of the joint problem.

    Attributes
    ----------
    jerk_m_s3
        Deviation of the jerk before it is re-estimated: g within 0.1 s, looser than a fall. By hand.
    u_place_m
        Uncertainty of the adaptive places about the first spline. Chosen by hand: their scatter at 30 dB.
    release_s
        Duration of the release after the onset: its jerk must not loosen the prior of the following fall. Chosen by
        hand.
    onset_late_s
        Largest delay with which the onset is seen: a fall of 10 ms is 0.5 mm long, a tenth of a radian or two.
    amplitude_map_length_m
        Correlation length of log A: antenna lobes are wide. Shorter ones describe what a floor does, smoother ones
        invent walls (accuracy benchmark).
    """

    jerk_m_s3: float = 100.0
    u_place_m: float = 1e-4
    release_s: float = 0.010
    onset_late_s: float = 0.010
    amplitude_map_length_m: float = 0.10


INITIAL = InitialSettings()


def release_times(onset_s: float) -> FloatArray:
    """Return the times between which the release needs finer knots, (2,), because gravity sets in at once.

    With 10 ms between them the acceleration rang for 60 ms after it (1.6, -0.8, 0.4 m/s^2), and the deviation from the
    equation of flight, re-estimated from that, let the whole first fall bend by 0.03 mm.
    """
    return onset_s - np.array([INITIAL.onset_late_s, 0.0])


def first_motion(data: BinnedData, place: FloatArray, start_s: float, break_s: FloatArray) -> SplineMotion:
    """Fit the motion's spline to the places of the adaptive rounds.

    Parameters
    ----------
    data
        Bins and geometry.
    place
        Positions at the bins, shape (3, n_bins).
    start_s, break_s
        Where the spline begins, and its breaks.
    """
    # a microsecond more, so that the last sample is inside
    spline = make_spline(start_s, float(data.bins.last_s[-1]) + 1e-6, break_s, release_times(data.onset_s))
    moving = ~data.rest
    rows = spline.rows(data.bins.time_s[moving])
    jerk, _, _ = spline.jerk()
    # long bins know their place better
    weight = data.bins.count[moving] / data.bins.count[moving].mean() / INITIAL.u_place_m**2
    # three times looser than the problem's own prior: the places shall decide, the prior fills what no bin sees
    band = rows.gram(weight) + jerk.gram(np.full(jerk.first.size, (3.0 * INITIAL.jerk_m_s3) ** -2.0))
    offset = (place[:, moving] - data.release_m[:, None]).T
    return SplineMotion(spline, solve_band(band[:, 1:], rows.transposed(weight[:, None] * offset)))


def initial_problem(
    data: BinnedData,
    motion: SplineMotion,
    constants: Sequence[ReceiverConstants],
    planes: tuple[MirrorPlane, ...],
    bias_length_m: float,
    known_front_ends: Sequence[LogFrontEnd] | None = None,
) -> Start:
    """Return the joint problem with maps, mirrors and drift at zero.

    Parameters
    ----------
    data
        Data and geometry.
    motion
        To start from.
    constants
        To start from, one a receiver.
    planes
        Mirrors to include.
    bias_length_m
        Correlation length of the bias maps.
    known_front_ends
        What earlier runs say about ln g and eps, one a receiver.
    """
    bins, spline = data.bins, motion.spline
    place = (spline.design(bins.time_s) @ motion.coefficients + data.release_m).T
    # the rest is one place, seen many times: it would claim a function of its own
    visited = place[:, ~data.rest]
    # one basis for all receivers: they look at the same places
    bias, amplitude = make_basis(visited, bias_length_m), make_basis(visited, INITIAL.amplitude_map_length_m)
    n_receivers, drift = data.antennas.n_receivers, data.drift
    layout = make_layout(
        Sizes(
            breaks=spline.break_s.size,
            mirrors=len(planes),
            receivers=n_receivers,
            bias=bias.size,
            amplitude_map=amplitude.size,
            drift=drift.shape[2],
            polarization=0 if data.sphere is None else 1,
            crosstalk=0 if data.multiplexer is None else 1,
            walls=len(walls_of(planes)),
            edges=0 if edges_of(planes) is None else 1,
        )
    )
    theta = np.zeros(layout.size)
    # mirrors and maps start at nothing: what they explain has to be asked for
    theta[layout.breaks] = spline.break_s
    for own, values in zip(layout.receivers, constants, strict=True):
        theta[own.constants] = values.in_order()
    prior = make_prior(layout, planes, spline.break_s, constants)
    lobes = lobe_places(layout)
    for places in (lobes, layout.exchange, layout.edges):
        theta[places] = prior.mean[places]
    if known_front_ends is not None:
        prior = with_known_front_ends(prior, layout, known_front_ends)
    if data.sphere is not None:
        prior = with_polarisation(prior, layout, data.sphere)
        angles = polarisation_places(layout)
        theta[angles] = prior.mean[angles]
    not_yet = np.zeros((bins.n_bins, 0))
    problem = JointProblem(
        bins=bins,
        delay_s=data.delay_s,
        spline=spline,
        layout=layout,
        inputs=ModelInputs(
            antennas=data.antennas,
            release_m=data.release_m,
            wavenumber=2.0 * np.pi / data.wavelength_m,
            planes=planes,
            bias=not_yet,
            amplitude_map=not_yet,
            range_factor=np.zeros((n_receivers, 0)),
            drift=drift,
            walls=data.walls,
            setup=data.setup,
        ),
        prior=prior,
        in_flight=np.zeros(sum(spline.spans), dtype=bool),
        equation_sd=np.full(sum(spline.spans), INITIAL.jerk_m_s3),
        noise_scale=np.ones(n_receivers),
        use=usable_bins(bins, spline.break_s),
        bias_basis=bias,
        amplitude_basis=amplitude,
        released_s=data.onset_s + INITIAL.release_s,
        gravity_m_s2=data.gravity_m_s2,
        sphere=data.sphere,
        multiplexer=data.multiplexer,
    )
    return Start(problem.at_places(place, theta), State(motion.coefficients, theta))


def usable_bins(bins: Bins, break_s: FloatArray) -> BoolArray:
    """Return which bins, (n_bins,), hold no break."""
    # breaks move while they are settled, bins do not
    before = np.searchsorted(break_s, bins.first_s)
    after = np.searchsorted(break_s, bins.last_s)
    return np.asarray(before == after)
