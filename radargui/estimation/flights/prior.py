"""What is assumed of a drop before a sample is looked at (method 4, Flights first)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.estimation.flights.drop_model import DropModel, Parts
from radargui.estimation.flights.linear_part import LinearPart
from radargui.estimation.flights.setup_unknowns import StatedSetup
from radargui.estimation.forward.bins import Bins, Multiplexer
from radargui.estimation.forward.parameters import Sizes, make_layout
from radargui.estimation.forward.signal_model import ModelInputs
from radargui.estimation.forward.slow_noise import NO_DRIFT, Drift
from radargui.estimation.forward.sphere import EXCHANGE, U_EXCHANGE, PolarisedSphere
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, uncertain_inputs
from radargui.model.gravity import drag_of_sphere, expected_gravity
from radargui.model.setup import Setup
from radargui.motion.flights import FlightLayout
from radargui.physics.edges import StatedEdges
from radargui.physics.mirrors import FLOOR, MirrorPlane
from radargui.physics.plate import StatedSurface


@dataclass(frozen=True, slots=True)
class DropPrior:
    """Standard deviations before a sample is looked at.

    Attributes
    ----------
    onset_s
        Against the onset that was seen: a magnet that holds on, a hand.
    first_velocity_m_s
        Of each component with which the body is let go.
    min_gravity_m_s2
        Of one that is called exact: what the samples say of it can then still be told.
    floor_tilt_rad, floor_shift_m
        Of the plane that reflects: below the surface that is touched lie plates of millimetres to centimetres.
    unknown_floor_m
        The shift before an impact has told where the floor is.
    reflection, stated_reflection
        Of real and imaginary part of T and R; the same where the setup says what the floor reflects.
    double_reflection
        Of X: what an even plate leaves.
    lobe_mean, lobe
        Of the lobe's functions (`lobes.LOBE_UNITS`).
    crosstalk
        kappa of a multiplexer.
    log_gain, quadrature_error_rad
        Of a front end nobody knows yet.
    """

    onset_s: float = 0.05
    first_velocity_m_s: float = 0.05
    min_gravity_m_s2: float = 1e-4
    floor_tilt_rad: float = 0.03
    floor_shift_m: float = 0.008
    unknown_floor_m: float = 0.08
    reflection: float = 0.4
    stated_reflection: float = 1.0
    double_reflection: float = 0.02
    lobe_mean: tuple[float, float, float] = (0.0, -0.9, 0.0)
    lobe: tuple[float, float, float] = (0.3, 2.0, 2.0)
    crosstalk: float = 0.005
    log_gain: float = 0.15
    quadrature_error_rad: float = 0.15


PRIOR = DropPrior()


def gravity_prior(setup: Setup) -> tuple[float, float]:
    """Return the acceleration of a fall at the setup's site, drag apart, and its u, m/s^2, by the setup's clock."""
    g, u = expected_gravity(setup.site, setup.tracer.density_kg_m3, setup.air.gas)
    # of a clock that is off by a share c accelerations are off by 2 c
    u_clock = next((one.u for one in uncertain_inputs(setup) if one.key == CLOCK), 0.0)
    return g, max(float(np.hypot(u, 2e-6 * u_clock * g)), PRIOR.min_gravity_m_s2)


def flights_prior(setup: Setup, onset_s: float) -> tuple[FloatArray, FloatArray]:
    """Return mean and deviation of the unknowns of one flight from an onset (`FlightLayout`)."""
    layout = FlightLayout(1)
    mean, deviation = np.zeros(layout.size), np.zeros(layout.size)
    mean[layout.onset], deviation[layout.onset] = onset_s, PRIOR.onset_s
    mean[layout.start] = setup.tracer.release_position_m
    mean[layout.gravity], deviation[layout.gravity] = gravity_prior(setup)
    drag = drag_of_sphere(setup.tracer.diameter_m, setup.tracer.density_kg_m3, setup.air.gas)
    mean[layout.drag], deviation[layout.drag], mean[layout.slow], deviation[layout.slow] = drag
    deviation[layout.velocity(0)] = PRIOR.first_velocity_m_s
    return mean, deviation


def drop_model(
    signals: ScaledSignals,
    setup: Setup,
    bins: Bins,
    flights: tuple[FloatArray, FloatArray],
    floor_m: float,
    known: tuple[StatedSetup, PolarisedSphere | None],
    linear: LinearPart,
    front_ends: Sequence[LogFrontEnd] | None = None,
    drift: Drift = NO_DRIFT,
) -> DropModel:
    """Return the model of a drop with the floor's surface at a height.

    Parameters
    ----------
    signals
        Delays and channels.
    setup
        The floor's normal, the release.
    bins
        Means of the samples.
    flights
        Mean and deviation of the unknowns of the flights.
    floor_m
        Where the plane that reflects is sought at the release's x and y.
    known
        Unknowns of the setup and the sphere, which every model of a drop shares.
    linear
        What is linear: a start's, or all of the forward model.
    front_ends
        What earlier runs say, one a receiver.
    drift
        Of the channels.
    """
    stated, sphere = known
    n_receivers = stated.n_receivers
    multiplexer = None if signals.before is None else Multiplexer(signals.before, 1.0 / signals.rate_hz)
    edges = StatedEdges.of(setup)
    layout = make_layout(
        Sizes(
            breaks=0,
            mirrors=1,
            receivers=n_receivers,
            bias=0,
            amplitude_map=0,
            drift=0,
            polarization=0 if sphere is None else 1,
            crosstalk=0 if multiplexer is None else 1,
            edges=0 if edges is None else 1,
        )
    )
    release = np.array(setup.tracer.release_position_m)
    surface = StatedSurface.of(setup)
    foot = np.array([release[0], release[1], floor_m])
    plane = MirrorPlane(foot, np.array(setup.floor.normal), FLOOR, surface=surface, edges=edges)
    mean, deviation = np.zeros(layout.size), np.zeros(layout.size)
    mean[layout.transmitter_lobe] = PRIOR.lobe_mean
    mean[layout.exchange].reshape(-1, 2)[:] = EXCHANGE
    if edges is not None:
        mean[layout.edges], deviation[layout.edges] = edges.values, edges.u
    for own in layout.receivers:
        mean[own.receiver_lobe] = PRIOR.lobe_mean
    if sphere is not None:
        angles = [layout.polarization, *(own.polarization for own in layout.receivers)]
        for places, angle in zip(angles, sphere.angle_rad, strict=True):
            mean[places] = angle
    deviation[layout.transmitter_lobe] = PRIOR.lobe
    for own in layout.receivers:
        deviation[own.receiver_lobe] = PRIOR.lobe
    if linear.free_ways:
        # its ways have phases of their own: no alias of the floor's height
        deviation[layout.planes.start + 2] = PRIOR.unknown_floor_m
    else:
        deviation[layout.planes] = PRIOR.floor_tilt_rad, PRIOR.floor_tilt_rad, PRIOR.floor_shift_m
        # what is stated is a term of its own
        u_reflection = PRIOR.reflection if surface is None else PRIOR.stated_reflection
        deviation[layout.transmitter_reflection] = u_reflection
        deviation[layout.exchange].reshape(-1, 2)[:] = U_EXCHANGE
        deviation[layout.crosstalk] = PRIOR.crosstalk
        for number, own in enumerate(layout.receivers):
            deviation[own.receiver_reflection] = u_reflection
            deviation[own.double_reflection] = PRIOR.double_reflection
            deviation[own.log_gain], deviation[own.quadrature_error] = PRIOR.log_gain, PRIOR.quadrature_error_rad
            if front_ends is not None:
                one = front_ends[number]
                mean[own.log_gain], deviation[own.log_gain] = one.log_gain, one.u_log_gain
                mean[own.quadrature_error] = one.quadrature_error_rad
                deviation[own.quadrature_error] = one.u_quadrature_error_rad
        if sphere is not None:
            for places, u in zip(angles, sphere.u_angle_rad, strict=True):
                deviation[places] = u
    none = np.zeros((bins.n_bins, 0))
    values = Parts(flights[0], stated.stated, mean)
    inputs = ModelInputs(
        stated.antennas(stated.stated),
        release,
        stated.wavenumber(stated.stated),
        (plane,),
        none,
        none,
        np.ones((n_receivers, bins.n_bins)),
        np.zeros((2 * n_receivers, bins.n_bins, 0)),
        walls=setup.container.walls,
    )
    model = DropModel(
        bins,
        np.ones(bins.n_bins, dtype=np.bool_),
        signals.delay_s,
        multiplexer,
        stated,
        sphere,
        plane,
        layout,
        linear,
        values,
        Parts(flights[1], np.zeros(stated.stated.size), deviation),
        inputs,
        np.ones((1 + linear.n_functions, bins.n_bins)),
        np.zeros((2, bins.n_bins)),
        (0.0, 0.0),
        np.ones(n_receivers),
        0.0,
        np.zeros(n_receivers),
        np.full((n_receivers, 2), linear.u_scattered),
        drift,
        np.zeros((2 * n_receivers, bins.n_bins, 0)),
    )
    return model.renewed(values)
