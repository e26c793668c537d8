"""The priors of the global parameters: wide for constants, re-estimated for maps and mirrors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from radargui.estimation.forward.parameters import (
    Layout,
    ReceiverConstants,
    lobe_places,
    of_mirror,
    polarisation_places,
)
from radargui.estimation.forward.sphere import EXCHANGE, U_EXCHANGE, PolarisedSphere
from radargui.estimation.hardware import LogFrontEnd
from radargui.model.arrays import FloatArray, IntArray
from radargui.model.gravity import TIDES_M_S2, U_ANYWHERE_M_S2, UNKNOWN_DRAG
from radargui.physics.mirrors import FLOOR, MirrorPlane, edges_of, has_floor, walls_of
from radargui.physics.setup_unknowns import SetupUnknowns


@dataclass(frozen=True, slots=True)
class Allowed:
    """Where a common deviation starts, between which limits it is re-estimated, and the mean of its own prior.

    In units of its coefficients.
    """

    start: float
    lowest: float
    highest: float
    scale: float = np.inf


@dataclass(frozen=True, slots=True)
class PriorSettings:
    """Deviations of the priors; amplitudes are those of the scaled samples, about one.

    The widths of constants are chosen by hand so that a short arc cannot run away and many fringes overrule them. The
    limits of the groups are chosen by hand: a deviation at the lowest switches a map off, one at the highest is as
    large as the signal itself.

    Attributes
    ----------
    break_s
        Of a break's time against its first guess from the adaptive rounds (s): kinks there are found to a bin, 4 ms.
    settled_break_s
        The same against a joint solution (s): a quarter of a bin.
    phase_rad
        More than a turn: the phase at rest is not known beforehand.
    log_amplitude, offset
        ln A against its start, and each offset in amplitudes.
    log_gain, quadrature_error_rad
        Against zero: front ends of 15 % and 9 degrees are ordinary (the receivers of the paper, the recordings of
        bench accuracy to 15 % and 10 degrees).
    reflection
        |T| and |R| of each mirror: at most some tenths, what a lossy floor or a table gives.
    wall_reflection
        The same of a wall. A weak wall's T and R are hardly determined: re-estimated without a lower limit their
        deviation shrinks with them, and with it the uncertainty of the motion (0.01 mm where the error was 0.11).
    harmonics
        Of a mixer, over the echo: -60 dBc; the samples say where it is more.
    double_reflection
        |X|, what the product of the factors leaves: small beside them.
    lobe
        Mean of the factors of lobes in `lobes.LOBE_UNITS`: of antennas of 16 dB that point to the origin, s = cos^9.
    u_main_lobe
        Their deviations directly and over a floor, which show them: antennas of 8 to 25 dB, 3 degrees off.
    u_wall_lobe
        The same over a wall where `lobe_prior` tells nothing better. Re-estimated from the samples they ran away, and
        two laboratory drops were 0.25 and 0.28 mm off instead of 0.09 and 0.03.
    sideways_m_s2
        Of the horizontal part of a flight's acceleration: what turns a sphere in air, and the Earth under it, make of
        2 m/s.
    crosstalk
        kappa: a multiplexer keeps parts in a thousand of the channel before. Where the samples do not ask for it, its
        deviation shrinks and switches it off.
    off_flight_m_s2
        Mean of the deviation from the equation of flight, one a knot, exp(-s / mean): where samples hardly determine it
        nothing else holds it, and it wandered between 0.004 and 0.02 from round to round, ln E by 30.
    bias, log_amplitude_map
        Coefficients of the maps; to the second nothing is left but antennas that do not point to the origin.
    bias_beside_floor
        The first beside a floor in the model: nothing is left to it but what no plane sends back, less than a wall of a
        few per cent does.
    """

    break_s: float = 0.003
    settled_break_s: float = 0.001
    phase_rad: float = 10.0
    log_amplitude: float = 0.5
    offset: float = 0.5
    log_gain: float = 0.15
    quadrature_error_rad: float = 0.15
    reflection: Allowed = Allowed(0.1, 1e-3, 0.2)
    wall_reflection: Allowed = Allowed(0.03, 0.02, 0.2)
    harmonics: float = 1e-3
    double_reflection: Allowed = Allowed(0.01, 1e-4, 0.3)
    lobe: tuple[float, ...] = (0.0, -0.9, 0.0)
    u_main_lobe: tuple[float, ...] = (0.3, 2.0, 2.0)
    u_wall_lobe: tuple[float, ...] = (0.3, 0.6, 2.0)
    sideways_m_s2: float = 1e-3
    crosstalk: Allowed = Allowed(0.003, 1e-5, 0.03)
    off_flight_m_s2: float = 0.02
    bias: Allowed = Allowed(0.02, 1e-4, 0.5)
    bias_beside_floor: Allowed = Allowed(0.02, 1e-4, 0.5, 0.005)
    log_amplitude_map: Allowed = Allowed(0.1, 1e-3, 0.5, 0.03)


PRIORS = PriorSettings()


@dataclass(frozen=True, slots=True)
class PriorGroup:
    """Coefficients with one common deviation, re-estimated within limits (MacKay 1992).

    Attributes
    ----------
    index
        Their places in theta.
    lowest, highest
        Limits of the deviation.
    scale
        Mean of the deviation's own prior, exp(-s / scale); infinite: all are alike.
    """

    index: IntArray
    lowest: float
    highest: float
    scale: float = np.inf


@dataclass(frozen=True, slots=True)
class Prior:
    """Independent Gaussian priors of the global parameters.

    Attributes
    ----------
    mean, sd
        Shape (layout.size,).
    groups
        Coefficients whose deviation is re-estimated from the posterior.
    """

    mean: FloatArray
    sd: FloatArray
    groups: list[PriorGroup] = field(default_factory=list)


def make_prior(
    layout: Layout,
    planes: tuple[MirrorPlane, ...],
    break_s: FloatArray,
    start: Sequence[ReceiverConstants],
    settings: PriorSettings = PRIORS,
) -> Prior:
    """Return wide priors for the constants, narrow growing ones for maps and mirrors.

    Parameters
    ----------
    layout
        Where the unknowns stand.
    planes
        The mirrors.
    break_s
        First guesses, shape (n_breaks,).
    start
        Where the fit starts, one a receiver: amplitude and offsets keep near it.
    settings
        Deviations.
    """
    mean, sd = np.zeros(layout.size), np.ones(layout.size)
    mean[layout.breaks], sd[layout.breaks] = break_s, settings.break_s
    # where a mirror was sought is a prior too: without it a plane that hardly reflects wanders off
    sd[layout.planes] = [deviation for plane in planes for deviation in plane.deviations]
    for one, value in ((mean, EXCHANGE), (sd, U_EXCHANGE)):
        one[layout.exchange].reshape(-1, 2)[:] = value
    if edges := edges_of(planes):
        mean[layout.edges], sd[layout.edges] = edges.values, edges.u
    lobes = lobe_places(layout)
    u_lobes = [settings.u_main_lobe, *[settings.u_wall_lobe] * len(walls_of(planes))]
    # fixed: re-estimated from the samples they ran away with a wall that was wrong (decision 33)
    mean[lobes], sd[lobes] = np.resize(settings.lobe, lobes.size), np.tile(np.ravel(u_lobes), 1 + len(layout.receivers))
    prior = Prior(mean, sd)

    def group(places: list[slice], allowed: Allowed) -> None:
        index = np.concatenate([np.arange(s.start, s.stop) for s in places]).astype(np.intp)
        if index.size:
            sd[index] = allowed.start
            prior.groups.append(PriorGroup(index, allowed.lowest, allowed.highest, allowed.scale))

    # a group each: what one mirror or map needs is no reason to loosen another
    group([layout.crosstalk], settings.crosstalk)
    receivers = layout.receivers
    for m, plane in enumerate(planes):
        # T and R of one surface share their deviation: where one is hardly seen, the others say how large it is
        reflections = [layout.transmitter_reflection, *(own.receiver_reflection for own in receivers)]
        # what is stated of a floor is a term of its own (`stated_floor`): the deviation of one holds nothing
        if plane.surface is None:
            group(
                [of_mirror(places, m) for places in reflections],
                settings.reflection if plane.name == FLOOR else settings.wall_reflection,
            )
        group([of_mirror(own.double_reflection, m) for own in receivers], settings.double_reflection)
    bias = settings.bias_beside_floor if has_floor(planes) else settings.bias
    # slow noise keeps N(0, 1) of its own functions, measured on the rest: the motion would lend it everything slow
    for own, constants in zip(receivers, start, strict=True):
        mean[own.log_amplitude], mean[own.offset] = constants.log_amplitude, (constants.offset_i, constants.offset_q)
        sd[own.phase], sd[own.log_amplitude], sd[own.offset] = (
            settings.phase_rad,
            settings.log_amplitude,
            settings.offset,
        )
        sd[own.log_gain], sd[own.quadrature_error] = settings.log_gain, settings.quadrature_error_rad
        sd[own.harmonics] = settings.harmonics
        # I and Q together: a slow phasor has no direction; receivers apart: each sees another side of the room
        group([own.bias_i, own.bias_q], bias)
        group([own.amplitude_map], settings.log_amplitude_map)
    return prior


def flight_prior(
    setup: SetupUnknowns | None, gravity_m_s2: float, settings: PriorSettings = PRIORS
) -> tuple[FloatArray, FloatArray]:
    """Return mean and deviation of g_x, g_y, g_z (m/s^2) and drag (1/m): the vertical is z by the setup's definition.

    What antennas lean by is an unknown of the setup, no horizontal part of gravity. Where the setup leaves nothing open
    g is that of the place.
    """
    g, u_g = (gravity_m_s2, U_ANYWHERE_M_S2) if setup is None else (setup.gravity_m_s2, setup.u_gravity_m_s2)
    sideways = settings.sideways_m_s2
    # a g that is called exact is held by what tides make of it
    u_g = max(u_g, TIDES_M_S2)
    k, u_k, *_ = UNKNOWN_DRAG if setup is None else setup.drag
    return np.array([0.0, 0.0, g, k]), np.array([sideways, sideways, u_g, u_k])


def with_polarisation(prior: Prior, layout: Layout, sphere: PolarisedSphere) -> Prior:
    """Return a prior in which the antennas' angles are what the setup says."""
    mean, sd = prior.mean.copy(), prior.sd.copy()
    places = polarisation_places(layout)
    mean[places], sd[places] = sphere.angle_rad, sphere.u_angle_rad
    return Prior(mean, sd, prior.groups)


def with_known_front_ends(prior: Prior, layout: Layout, known: Sequence[LogFrontEnd]) -> Prior:
    """Return a prior in which ln g, eps and harmonics are those of earlier runs, one a receiver."""
    mean, sd = prior.mean.copy(), prior.sd.copy()
    for own, front_end in zip(layout.receivers, known, strict=True):
        mean[own.log_gain], sd[own.log_gain] = front_end.log_gain, front_end.u_log_gain
        mean[own.quadrature_error] = front_end.quadrature_error_rad
        sd[own.quadrature_error] = front_end.u_quadrature_error_rad
        if front_end.harmonics:
            mean[own.harmonics], sd[own.harmonics] = front_end.harmonics, front_end.u_harmonics
    return Prior(mean, sd, prior.groups)
