"""A drop by its flights: from signals to motion, coefficients and what is known of the setup (method 4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from radargui.estimation.flights.drop_model import (
    DropModel,
    Evaluation,
    Parts,
    evaluate,
    minimise,
    normal_equations,
    robust_cost,
    with_scattered,
)
from radargui.estimation.flights.linear_part import ASIDE, LinearPart
from radargui.estimation.flights.prior import drop_model, flights_prior
from radargui.estimation.flights.setup_unknowns import StatedSetup, setup_unknowns
from radargui.estimation.flights.start import START, DropStart, followed_until, start_drop
from radargui.estimation.forward.bins import BinSettings, bin_by_fringe, clear_of_holder_s, pool
from radargui.estimation.forward.slow_noise import Drift, measure_drift
from radargui.estimation.forward.sphere import PolarisedSphere, polarised_sphere, supposed_spheres
from radargui.estimation.forward.stated_floor import begun_as_stated
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.signals import ScaledSignals, is_far
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.finding import Finding, refuse
from radargui.model.setup import Setup
from radargui.motion.flights import Flights
from radargui.physics.edges import SIDES
from radargui.physics.path_length import path_gradient
from radargui.physics.plate import Plate, changes_faster


@dataclass(frozen=True, slots=True)
class DropSettings:
    """How a drop is measured once it is begun.

    Attributes
    ----------
    bins
        Two nodes keep a mean over 1/12 fringe to 2e-5 of the wave.
    n_functions, n_uneven
        Of the height, for amplitudes and offsets, and for the ways over the floor.
    rest_s
        Of the rest that counts: offsets, and the phase at release.
    first_sigma, first_apart_s
        While impacts are known to half a millisecond: no bin counts as better known, none so near one counts.
    apart_s
        Bins so near an impact do not count: a sphere touches a hard floor for up to 0.14 ms (Hertz).
    plate_m
        How far below the surface that is touched the plane that reflects is expected.
    plate_share
        Of |R| K a (a / (a + gap))^2, what one R for all directions leaves of glass, acrylic and granite, in amplitudes.
    edges_share
        What comes over the edges of a plate is known to so much of |R|: Kirchhoff's integral over plates of 5 to 15 cm
        has corners, too, and differs by 0.045 (from above) and 0.07 (aslant), rms, within 2 cm, by a third at 10 cm.
    max_off
        Of ln g and of the quadrature error (rad) that a start may find.
    block_s
        Residuals are averaged over so long a time to tell how far they are from white.
    """

    bins: BinSettings = field(default_factory=lambda: BinSettings(per_fringe=12.0))
    n_functions: int = 12
    n_uneven: int = 4
    rest_s: float = 0.1
    first_sigma: float = 0.01
    first_apart_s: float = 0.001
    apart_s: float = 0.00015
    plate_m: float = 0.005
    plate_share: float = 0.1
    edges_share: float = 0.06
    max_off: float = 0.5
    block_s: float = 0.005


DROP = DropSettings()


@dataclass(frozen=True, slots=True)
class DropEstimate:
    """A drop with its posterior.

    Attributes
    ----------
    start
        What it was begun from.
    model, unknowns, at
        The minimum.
    covariance, held
        Of the unknowns, by the noise that the samples have; the same with what the setup states held, shape (n, n).
    linear_by_unknowns
        What the linear coefficients change by with the unknowns, shape (n_receivers, n_columns, n).
    block_chi_square
        Mean square of residuals averaged over 5 ms, in what white noise leaves of them, one a receiver.
    """

    start: DropStart
    model: DropModel
    unknowns: FloatArray
    at: Evaluation
    covariance: FloatArray
    held: FloatArray
    linear_by_unknowns: FloatArray
    block_chi_square: FloatArray

    @property
    def flights(self) -> Flights:
        """Where the sphere was."""
        return Flights.of(self.at.values.flights)

    @property
    def end_s(self) -> float:
        """Until when it was followed: where the last flight lands is known better than while it was begun."""
        return followed_until(self.start.end_s, self.at.values)

    @property
    def widening(self) -> float:
        """Factor on uncertainties by white noise: the root of the largest block chi-square, where that exceeds one.

        What a receiver sees besides moves the place along its own direction, and the others do not halve it: with noise
        so much larger in each the covariance is at most this much larger in any direction.
        """
        return float(np.sqrt(max(1.0, self.block_chi_square.max())))

    @property
    def has_far_mixer(self) -> bool:
        """Whether a front end was found so far from a perfect one that its prior would hold it back."""
        theta = self.at.values.theta
        return any(is_far(theta[own.log_gain], theta[own.quadrature_error]) for own in self.model.layout.receivers)

    @property
    def max_pull(self) -> float:
        """By how much a direction of the setup was found off what is stated, at most, in its u."""
        return float(np.abs(self.unknowns[: len(self.model.setup.directions)]).max(initial=0.0))

    @property
    def by_setup(self) -> FloatArray:
        """What the unknowns change by along independent directions in which the setup is left open, (n_stated, n).

        With `held` they make up the covariance: C = H + sum of d d^T.
        """
        n_stated = len(self.model.setup.directions)
        apart = self.covariance[:, :n_stated]
        # of a block matrix: C - H = C_s C_ss^-1 C_s^T
        root = np.linalg.cholesky(np.linalg.inv(apart[:n_stated])) if n_stated else np.zeros((0, 0))
        return np.asarray((apart @ root).T)

    @property
    def gravity(self) -> tuple[float, float]:
        """Acceleration g and its u, m/s^2, with the prior of g taken off again."""
        model = self.model
        values = np.zeros(model.free.size)
        values[Flights.of(model.mean.flights).layout.gravity] = 1.0
        place = len(model.setup.directions) + int(np.flatnonzero(values[model.free])[0])
        g, u = float(self.at.values.flights[4]), float(model.deviation.flights[4])
        variance, share = float(self.covariance[place, place]), float(self.unknowns[place])
        # information of the samples alone; where they tell nothing the prior is all there is
        alone = 1.0 / max(1.0 / variance - 1.0, 1e-6)
        return g + u * share * alone, u * float(np.sqrt(alone)) * self.widening

    def choices(self) -> tuple[str, ...]:
        """Return what was found on the way, one sentence each."""
        theta, layout, plane = self.at.values.theta, self.model.layout, self.model.plane
        reflection = float(np.hypot(*theta[layout.transmitter_reflection]))
        height = float(plane.foot_m[2] + theta[layout.planes.start + 2])
        out = [f"{self.flights.layout.n_flights} flights followed to {self.end_s:.3f} s."]
        if reflection > 0.02:
            out.append(f"A floor at z = {1e3 * height:.1f} mm that reflects {reflection:.2f} of the field.")
        return tuple(out)

    def by_unknowns(self, by_flights: FloatArray) -> FloatArray:
        """Return derivatives by the unknowns, (..., n), of those by the flights' values, (..., n_flights_values)."""
        columns = np.zeros((*by_flights.shape[:-1], self.model.free.size))
        columns[..., self.model.flights] = by_flights
        return self.model.by_unknowns(columns)

    def impact_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the velocities before and after each impact between flights, (n_impacts, 6), and their derivatives.

        These by the unknowns, (n_impacts, 6, n).
        """
        flights = self.flights
        layout = flights.layout
        after = np.zeros((layout.n_flights - 1, 3, layout.size))
        for number, rows in enumerate(after):
            rows[:, layout.velocity(number + 1)] = np.eye(3)
        slopes = np.concatenate([flights.velocity_before_slopes(), after], axis=1)
        values = np.concatenate([flights.velocity_before_m_s(), flights.velocity_m_s[1:]], axis=1)
        return values, self.by_unknowns(slopes)


def estimate_drop(
    signals: ScaledSignals,
    setup: Setup,
    *,
    front_ends: Sequence[LogFrontEnd] | None = None,
    begun: DropStart | None = None,
    watch: Callable[[], None] | None = None,
) -> DropEstimate | Finding:
    """Measure a drop; return why not where none could be followed.

    Parameters
    ----------
    signals
        From a rest on.
    setup
        With what it states and how well.
    front_ends
        What earlier runs say, one a receiver.
    begun
        How the same drop was begun with more of its samples; None: begun blind.
    watch
        Called now and then: what it raises ends the work.
    """
    known = setup_unknowns(setup), polarised_sphere(setup)
    start = _started(signals, setup, known) if begun is None else begun
    if start.why is not None and start.flights.layout.n_flights == 1:
        return start.why
    if backwards := _backwards(start):
        return refuse("receivers_backwards", receivers=" and ".join(map(str, backwards)))
    stated, sphere = known
    spheres = [None, *supposed_spheres(setup)] if sphere is None else [sphere]
    drift, first = measure_drift(signals, signals.rest_end_s), []
    for one in spheres:
        model, values = _begun(start, signals, setup, (stated, one), front_ends, drift)
        model, values = _with_bins(model, values, signals, setup, start.end_s, DROP.first_apart_s)
        model = replace(model, min_sigma=DROP.first_sigma)
        first.append(minimise(model, model.unknowns(values), rounds=2, steps=6, min_gain=1.0, watch=watch))
    # of polarisations that are not told those that explain it best; a point where they gain less than an unknown does
    model, unknowns, at = min(first, key=lambda fit: robust_cost(*fit) + fit[0].n_unknowns)
    model, values = _with_bins(model, at.values, signals, setup, start.end_s, DROP.apart_s)
    model = replace(model, min_sigma=0.0)
    for _ in range(2):
        unknowns = model.unknowns(values)
        at = evaluate(model, unknowns)
        model = replace(model, noise=_noise_scale(model, at), turn=np.angle(_amplitude(at)))
        model = with_scattered(model, evaluate(model, unknowns))
        model, unknowns, at = minimise(model, unknowns, rounds=3, steps=6, watch=watch)
        values = at.values
    equations = normal_equations(model, unknowns, at)
    covariance, held = np.asarray(np.linalg.inv(equations.matrix)), np.zeros_like(equations.matrix)
    n_stated = len(model.setup.directions)
    held[n_stated:, n_stated:] = np.linalg.inv(equations.matrix[n_stated:, n_stated:])
    return DropEstimate(
        start,
        model,
        unknowns,
        at,
        covariance,
        held,
        equations.linear_by_unknowns,
        block_chi_square(model, at),
    )


def _started(signals: ScaledSignals, setup: Setup, known: tuple[StatedSetup, PolarisedSphere | None]) -> DropStart:
    """Follow a drop with the fewest functions of the height that do; where none do, as far as any."""
    bins = pool(signals, START.bin_s)
    flights = flights_prior(setup, signals.onset_s)
    below = float(setup.tracer.release_position_m[2]) - START.deep_m
    starts: list[DropStart] = []
    for n_functions in START.n_functions:
        model = drop_model(signals, setup, bins, flights, below, known, LinearPart(True, n_functions))
        starts.append(start_drop(model, bins))
        if starts[-1].why is None:
            return starts[-1]
    return max(starts, key=lambda one: one.flights.layout.n_flights)


def _amplitude(at: Evaluation) -> ComplexArray:
    return np.asarray(at.coefficients[:, 0] + 1j * at.coefficients[:, 1])


def _begun(
    start: DropStart,
    signals: ScaledSignals,
    setup: Setup,
    known: tuple[StatedSetup, PolarisedSphere | None],
    front_ends: Sequence[LogFrontEnd] | None,
    drift: Drift,
) -> tuple[DropModel, Parts]:
    """Return the whole model with what the start says of flights, floor and front ends."""
    flights = start.flights
    # a fall that ends dead ends on the floor
    touch = flights.position_m(np.append(flights.impact_s, start.end_s)[:1])
    surface = float(touch[2, 0]) - 0.5 * setup.tracer.diameter_m
    # of a plate that is stated what is touched reflects
    surface -= 0.0 if Plate.of(setup.floor) is not None else DROP.plate_m
    prior = start.model.mean.flights, start.model.deviation.flights
    model = drop_model(signals, setup, start.model.bins, prior, surface, known, _whole(setup), front_ends, drift)
    own, image = _own_and_image(start)
    together = own + image.conj()
    front_end = (own[:, 0] - image[:, 0].conj()) / together[:, 0]
    got, sent = (together[:, 1:3] / together[:, :1]).T
    theta, layout = model.mean.theta.copy(), model.layout
    begun = start.at.values.theta
    theta[layout.transmitter_lobe] = begun[start.model.layout.transmitter_lobe]
    theta[layout.transmitter_reflection] = sent.mean().real, sent.mean().imag
    for number, (now, was) in enumerate(zip(layout.receivers, start.model.layout.receivers, strict=True)):
        theta[now.receiver_lobe] = begun[was.receiver_lobe]
        theta[now.receiver_reflection] = got[number].real, got[number].imag
        # no mixer is farther off than this: what a start of few fringes finds beyond is its own error
        theta[now.log_gain] = np.clip(np.log(np.abs(front_end[number])), -DROP.max_off, DROP.max_off)
        theta[now.quadrature_error] = np.clip(np.angle(front_end[number]), -DROP.max_off, DROP.max_off)
    return model, start.at.values._replace(theta=begun_as_stated(theta, layout, model.inputs))


def _whole(setup: Setup) -> LinearPart:
    # the joint estimate has no such functions: what it begins from has none either, or it begins beside its minimum
    n_aside = ASIDE if setup.processing.correction == "flights" else 0
    return LinearPart(False, DROP.n_functions, n_uneven=DROP.n_uneven, n_aside=n_aside)


def _own_and_image(start: DropStart) -> tuple[ComplexArray, ComplexArray]:
    """Return the amplitudes of each way and of its mirror image in the IQ plane, each (n_receivers, 4)."""
    pairs = start.at.coefficients[:, 0:16:2] + 1j * start.at.coefficients[:, 1:16:2]
    return pairs[:, :4], pairs[:, 4:]


def _backwards(start: DropStart) -> tuple[int, ...]:
    """Return which receivers, from 1, show the image of the echo rather than the echo itself.

    I and Q are a real matrix times Re Z, Im Z: exchanged or inverted its determinant, |own|^2 - |image|^2, is negative.
    """
    own, image = _own_and_image(start)
    return tuple((1 + np.flatnonzero(np.abs(image[:, 0]) > np.abs(own[:, 0]))).tolist())


def _with_bins(
    model: DropModel, values: Parts, signals: ScaledSignals, setup: Setup, end_s: float, apart_s: float
) -> tuple[DropModel, Parts]:
    """Return the model with bins broken at the impacts, those nearer to one not used."""
    flights = Flights.of(values.flights)
    turns = echo_turns_hz(model, values, signals.time_s)
    bins = bin_by_fringe(signals, signals.time_s, turns, flights.onset_s - 0.02, flights.impact_s, DROP.bins)
    inside = (bins.time_s > flights.onset_s - DROP.rest_s) & (bins.time_s < followed_until(end_s, values))
    bins = model.drift.widen(bins.of(np.flatnonzero(inside)))
    bins = bins.weakened(bins.time_s < clear_of_holder_s(setup, flights.onset_s))
    if Plate.of(setup.floor) is None:
        bins = bins.known_to(_of_unknown_plate(model, values, bins.time_s))
    bins = bins.known_to(_of_edges(model, values, bins.time_s))
    model = model.of_bins(bins, values)
    apart = np.ones(bins.n_bins, dtype=np.bool_)
    half = 0.5 * (bins.last_s - bins.first_s)
    for impact in flights.impact_s:
        apart &= np.abs(bins.time_s - impact) > half + apart_s
    return replace(model, used=apart), values


def echo_turns_hz(model: DropModel, values: Parts, time_s: FloatArray, at_least: float = 1.0) -> FloatArray:
    """Return how fast what the receivers get changes, at most, of flights at times (n,): turns a second.

    `at_least` so many times faster than the direct wave turns.
    """
    flights, layout = Flights.of(values.flights), model.layout
    position, velocity = flights.position_m(time_s), flights.velocity_at(time_s)
    gradient = path_gradient(position, model.setup.antennas(values.setup))
    turns = np.abs(np.einsum("ran,an->rn", gradient, velocity)).max(axis=0) / model.setup.wavelength_m
    reflection = float(np.hypot(*values.theta[layout.transmitter_reflection]))
    gap_m, radius_m = _gap_m(flights, position[2]), 0.0 if model.sphere is None else model.sphere.sphere.radius_m
    return np.asarray(turns * np.maximum(changes_faster(gap_m, reflection, radius_m), at_least))


def _gap_m(flights: Flights, height_m: FloatArray) -> FloatArray:
    """Return how far above where it touches a sphere at heights (n,) is, shape (n,)."""
    return np.asarray(height_m - flights.position_m(flights.impact_s)[2].min(initial=height_m.min()))


def _of_unknown_plate(model: DropModel, values: Parts, time_s: FloatArray) -> FloatArray:
    """Return how well what a floor and the sphere send to and fro is known, in amplitudes, of times (n,), shape (n,).

    A plate that is not stated has another R for each of these waves, see `DROP.plate_share`.
    """
    if model.sphere is None:
        return np.zeros(time_s.size)
    flights, sphere = Flights.of(values.flights), model.sphere.sphere
    gap_m = np.maximum(_gap_m(flights, flights.position_m(time_s)[2]), 0.0)
    reflection = min(float(np.hypot(*values.theta[model.layout.transmitter_reflection])), 1.0)
    near = (sphere.radius_m / (sphere.radius_m + gap_m)) ** 2
    return np.asarray(DROP.plate_share * reflection * sphere.size * near)


def _of_edges(model: DropModel, values: Parts, time_s: FloatArray) -> FloatArray:
    """Return how well what comes over the edges of a plate is known, in amplitudes, of times (n,), shape (n,)."""
    if not (half_m := values.theta[model.layout.edges][SIDES]).size:
        return np.zeros(time_s.size)
    reflection = min(float(np.hypot(*values.theta[model.layout.transmitter_reflection])), 1.0)
    flights, side_m = Flights.of(values.flights), float(half_m.mean())
    gap_m = np.maximum(_gap_m(flights, flights.position_m(time_s)[2]), 0.0)
    return np.asarray(DROP.edges_share * reflection * side_m / (side_m + gap_m))


def _noise_scale(model: DropModel, at: Evaluation) -> FloatArray:
    """Return by how much residuals exceed the noise, one a receiver: the median, which a short misfit does not move."""
    # the mean of two squares of normal numbers has the median ln 2
    median = np.median(at.misfit[:, model.used], axis=1) / np.log(2.0)
    return np.asarray(np.sqrt(np.maximum(1.0, median)))


def block_chi_square(model: DropModel, at: Evaluation) -> FloatArray:
    """Return the mean square of residuals averaged over blocks, in what white noise leaves, one a receiver."""
    time = model.bins.time_s[model.used]
    label = np.floor((time - time[0]) / DROP.block_s).astype(int)
    first = np.flatnonzero(np.diff(label, prepend=-1))
    count = np.diff(np.append(first, label.size))
    weight = np.sqrt(at.weight[:, None, model.used]) / model.noise[:, None, None]
    sums = np.add.reduceat(at.residual[:, :, model.used] * weight, first, axis=-1) / np.sqrt(count)
    return np.asarray((sums**2).mean(axis=(1, 2)) * model.noise**2)
