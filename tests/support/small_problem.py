"""A small joint problem with known truth: half a second, one bounce, three receivers, made by the model itself."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.bins import BinnedData, Bins, Multiplexer
from radargui.estimation.forward.parameters import ReceiverConstants, lobe_places
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.forward.sphere import PolarisedSphere
from radargui.estimation.solve.initial_problem import first_motion, initial_problem
from radargui.estimation.solve.problem import Start, State, linearise
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.scattering import mie_sphere, transmitted_direction, transverse_axes
from radargui.physics.mirrors import FLOOR, WALL, MirrorPlane
from radargui.physics.path_length import Antennas

ANTENNAS = Antennas(np.array([0.0, 0.0, 0.7]), np.array([[0.45, 0.0, 0.53], [-0.2, 0.4, 0.55], [-0.25, -0.4, 0.5]]))
LARGE_SPHERE = PolarisedSphere(
    mie_sphere(0.008, 0.03),
    np.stack([transmitted_direction(0.0), transmitted_direction(90.0)]),
    np.array([transverse_axes(rx / np.linalg.norm(rx)) for rx in ANTENNAS.receivers_m]),
    np.radians([20.0, 50.0, 0.0, 100.0]),
    np.radians([5.0, 5.0, 5.0, 5.0]),
)
RELEASE_M = np.array([0.0, 0.01, 0.12])
WAVELENGTH_M = 0.03
START_S, BOUNCE_S, END_S = 0.05, 0.25, 0.45
WALL_S, ASIDE_M_S, BACK_M_S = 0.15, 0.3, -0.2
FLOOR_PLANE = MirrorPlane(np.array([0.0, 0.0, -0.11]), np.array([0.0, 0.0, 1.0]), FLOOR)
WALL_PLANE = MirrorPlane(np.array([0.14, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]), WALL, 0.15)
CONSTANTS = tuple(
    ReceiverConstants(0.3 + n, 0.02 * n, 0.1 - 0.05 * n, -0.04 + 0.03 * n, 0.05 - 0.04 * n, 0.04 * n - 0.03)
    for n in range(3)
)


def positions(time_s: np.ndarray, *, wall_s: float | None = None) -> np.ndarray:
    """Return a fall from rest at START_S, a bounce with e = 0.7 at BOUNCE_S, a slow drift along x, shape (3, n).

    Where there is a wall, it goes along x with ASIDE_M_S, and is thrown back at `wall_s`.
    """
    t = np.clip(time_s - START_S, 0.0, None)
    fall = BOUNCE_S - START_S
    after = time_s - BOUNCE_S
    z = np.where(after < 0.0, -4.905 * t**2, -4.905 * fall**2 + 0.7 * 9.81 * fall * after - 4.905 * after**2)
    aside = 0.05 * t
    if wall_s is not None:
        back = ASIDE_M_S * (wall_s - START_S) + BACK_M_S * (time_s - wall_s)
        aside = np.where(time_s < wall_s, ASIDE_M_S * t, back)
    return np.stack([RELEASE_M[0] + aside, RELEASE_M[1] + 0.0 * t, RELEASE_M[2] + z])


@dataclass(frozen=True)
class SmallProblem:
    """The data, the problem at the truth, and the true state."""

    data: BinnedData
    problem: object
    truth: State

    @property
    def start(self) -> Start:
        """The problem, started at the truth."""
        return Start(self.problem, self.truth)

    def away(self, size: float, seed: int = 1) -> Start:
        """Return the problem started near the truth."""
        rng = np.random.default_rng(seed)
        theta = self.truth.theta + size * 0.02 * rng.standard_normal(self.truth.theta.size)
        theta[self.problem.layout.breaks] = self.truth.theta[self.problem.layout.breaks] + size * 2e-4
        layout = self.problem.layout
        for places in (layout.planes, *(own.harmonics for own in layout.receivers)):
            theta[places] = self.truth.theta[places]
        coefficients = self.truth.coefficients + size * 2e-4 * rng.standard_normal(self.truth.coefficients.shape)
        return Start(self.problem, State(coefficients, theta))


def no_drift(channels: int = 6) -> Drift:
    """Return white noise."""
    return Drift(0.0, END_S, 0, np.zeros((channels, 0)), np.zeros(channels))


def small_problem(
    planes: tuple[MirrorPlane, ...] = (),
    *,
    reflection: float = 0.0,
    sigma: float = 0.01,
    seed: int = 0,
    delay_s: float = 0.0,
    drift: Drift | None = None,
    n_bins: int = 250,
    shown: tuple[MirrorPlane, ...] | None = None,
    breaks_s: tuple[float, ...] = (BOUNCE_S,),
    crosstalk: float | None = None,
    lobe: float | None = None,
    wall_s: float | None = None,
) -> SmallProblem:
    """Make a problem whose data the model shows at a known state.

    Parameters
    ----------
    planes
        Mirrors of the model.
    reflection
        T and R of the mirrors in the data.
    sigma, seed
        White noise of a bin.
    delay_s
        Multiplexer: delay from channel to channel.
    drift
        Slow noise of the model; the data have none.
    shown
        Mirrors in the data where they differ from the model's.
    breaks_s
        Breaks of the model's motion; the data have one, at BOUNCE_S, and another at the wall.
    crosstalk
        kappa in the data; None: the model knows none.
    lobe
        What ln s of each antenna in the data goes with the angle by; None: as the prior expects.
    wall_s
        When the body in the data meets a wall beside its fall; None: never.
    """
    time = np.linspace(0.0, END_S, n_bins + 1)
    middle, half = (time[:-1] + time[1:]) / 2.0, np.diff(time) / 2.0
    ones = np.ones((6, n_bins))
    bins = Bins(
        middle,
        half / np.sqrt(3.0),
        0.0 * ones,
        sigma * ones,
        np.full(n_bins, 8),
        time[:-1],
        time[1:] - 1e-6,
        ones,
    )
    delay = delay_s * np.arange(6.0)
    multiplexer = None if crosstalk is None else Multiplexer(np.array([0.8, 1.0, 1.25, 1.0, 0.7, 1.0]), 2e-4)
    data = BinnedData(
        bins, ANTENNAS, RELEASE_M, WAVELENGTH_M, middle < START_S, delay, START_S, NOMINAL_GRAVITY_M_S2,
        multiplexer=multiplexer, slow_noise=None if drift is None else drift.uncorrelated(bins),
    )  # fmt: skip
    place = positions(middle, wall_s=wall_s)
    shown_s = sorted([BOUNCE_S] if wall_s is None else [wall_s, BOUNCE_S])
    motion = first_motion(data, place, START_S, np.array(shown_s))

    def made(mirrors: tuple[MirrorPlane, ...]) -> Start:
        return initial_problem(data, motion, CONSTANTS, mirrors, 0.09)

    in_data = made(planes if shown is None else shown)
    theta = with_reflection(in_data, reflection)
    theta[in_data.problem.layout.crosstalk] = crosstalk
    if lobe is not None:
        theta[lobe_places(in_data.problem.layout)[1::3]] = lobe
    value = np.concatenate([s.value for s in linearise(in_data.problem, State(motion.coefficients, theta)).signals])
    value += sigma * np.random.default_rng(seed).standard_normal(value.shape)
    data = replace(data, bins=replace(bins, value=value))
    motion = first_motion(data, place, START_S, np.array(breaks_s))
    start = made(planes)
    truth = State(motion.coefficients, with_reflection(start, reflection) if shown is None else start.state.theta)
    return SmallProblem(data, start.problem, truth)


def with_reflection(start: Start, reflection: float) -> np.ndarray:
    """Return theta with T = R = reflection in every mirror."""
    theta, layout = start.state.theta.copy(), start.problem.layout
    theta[layout.transmitter_reflection][0::2] = reflection
    for own in layout.receivers:
        theta[own.receiver_reflection][0::2] = reflection
    return theta
