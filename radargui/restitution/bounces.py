"""Bounces of a located track: its flights fitted to the path lengths, e and g with what the setup leaves open.

Method 5, Flights.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, median, robust_sd
from radargui.model.finding import Finding
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Bounce, Bounces, FreeFall, PathLengths, Segment, Track, VelocitiesAtImpacts
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupPosterior
from radargui.motion.flights import Flights
from radargui.motion.impacts import THIRD_DIFFERENCE_GAIN
from radargui.physics.setup_unknowns import SetupUnknowns
from radargui.restitution.cross_check import OF_PATHS, cross_check, without_checks_by_walls
from radargui.restitution.drop_bounces import bounce_at, fall_of, normal_of_velocities
from radargui.restitution.floor_normal import FloorNormal
from radargui.restitution.path_fit import FittedPaths, PathModel, PathSamples, SharedPrior, fit_paths
from radargui.restitution.settings import FLIGHTS, PATHS, TRACKS
from radargui.restitution.setup_chi_square import SetupChiSquare
from radargui.restitution.setup_outlier import setup_outlier
from radargui.restitution.track_flights import TrackFlights, find_track_flights
from radargui.restitution.walls_of_track import walls_of_flights
from radargui.signals.averager import block_means


@dataclass(frozen=True, slots=True)
class FlightChain:
    """Flights that were fitted together.

    Attributes
    ----------
    first
        Number of the first of them among all flights of the track: its impacts are those from this one on.
    fit
        Of their paths.
    """

    first: int
    fit: FittedPaths

    @property
    def impacts(self) -> slice:
        """Which impacts of the track lie between these flights."""
        return slice(self.first, self.first + self.fit.flights.impact_s.size)


@dataclass(frozen=True, slots=True)
class FlownTrack:
    """What the flights of a track say.

    Attributes
    ----------
    bounces
        With their statistical uncertainties: setup held.
    chains
        Of its flights; none where nothing flies.
    widening
        What all uncertainties were multiplied by, for the setup is farther off than it states.
    cause
        What of the setup is likely wrong.
    """

    bounces: Bounces
    chains: tuple[FlightChain, ...] = ()
    widening: float = 1.0
    cause: Finding | None = None

    @property
    def posterior(self) -> SetupPosterior | None:
        """What the flights say of the setup; None where nothing flies, or the setup has no unknowns."""
        return self.chains[-1].fit.setup_posterior() if self.chains and self.chains[-1].fit.n_setup else None

    def directions(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return independent directions in which the setup is left open, and how e and g change along each.

        Shapes (n, n_setup), in the u of the inputs, (n, n_impacts) and (n,).
        """
        if not self.chains:
            nothing = np.zeros((0, len(self.bounces.impacts)))
            return np.zeros((0, 0)), nothing, np.zeros(0)
        last, first = self.chains[-1].fit, self.chains[0].fit
        n = last.n_setup
        along = self.widening * last.directions(last.covariances()[0])[:, :n]
        e = np.full((n, len(self.bounces.impacts)), np.nan)
        for chain in self.chains:
            covariance, _ = chain.fit.covariances()
            # where the setup is off by this, and the flights follow
            follows = np.linalg.solve(covariance[:n, :n], covariance[:n]).T
            e[:, chain.impacts] = along @ (self._e_slopes(chain) @ follows).T
        _, of_g, _ = first.without_g()
        return along, e, self.widening * first.directions(of_g)[:, first.gravity_place]

    def by_paths(self, time_s: FloatArray, longer_m: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Return what the setup's unknowns, (n_setup,), e, (n_impacts,), and g change by with small changes of paths.

        Parameters
        ----------
        time_s, longer_m
            Instants, and changes of the paths there, shape (n_receivers, n).
        """
        e, setup, g = np.full(len(self.bounces.impacts), np.nan), np.zeros(0), np.nan
        for number, chain in enumerate(self.chains):
            fit = chain.fit
            at = np.array([np.interp(fit.samples.time_s, time_s, row) for row in longer_m])
            change, of_g = fit.response(at)
            e[chain.impacts] = self._e_slopes(chain) @ change
            if number == 0:
                setup, g = change[: fit.n_setup], of_g
        return setup, e, g

    def _e_slopes(self, chain: FlightChain) -> FloatArray:
        """Return the derivatives of e of a chain's impacts by its unknowns, (n_impacts, m)."""
        velocity, slopes = chain.fit.velocities()
        normal = np.asarray(self.bounces.normal)
        into, out = -velocity[:, :3] @ normal, velocity[:, 3:] @ normal
        by_before, by_after = (np.einsum("a,eam->em", normal, one) for one in (slopes[:, :3], slopes[:, 3:]))
        return np.asarray((by_after + (out / into)[:, None] * by_before) / into[:, None])


def find_bounces(track: Track, paths: PathLengths, segment: Segment, setup: Setup, sample_rate_hz: float) -> FlownTrack:
    """Return impacts with e = speed after / speed before along the floor's normal, and the first fall.

    Where the track shows impacts the flights between them are fitted to the paths, together with what the setup leaves
    open; the speeds are those with which the flights meet.

    Parameters
    ----------
    track, paths
        Places, and the path lengths that they were located from.
    segment
        The motion within both.
    setup
        Antennas, release, sphere, site and floor, with their uncertainties. Where it gives no normal that is found from
        the impacts, its uncertainty a part of u_e.
    sample_rate_hz
        Of both.
    """
    gravity_m_s2 = expected_gravity_m_s2(setup.site)
    flights = find_track_flights(track, segment, sample_rate_hz, gravity_m_s2)
    if not isinstance(flights, TrackFlights):
        return FlownTrack(Bounces(falls_with_m_s2=flights))
    given = np.asarray(setup.floor.normal)
    turned, thrown, walls_s = walls_of_flights(track, flights, given, gravity_m_s2)
    samples = _means(paths, segment, sample_rate_hz)
    chains = tuple(_fitted(flights, flights.are_known, samples, setup))
    if walls_s and chains:
        # antennas that stand elsewhere than stated bend flights, too: located with them as found these meet no wall
        again = walls_of_flights(_located(chains[0].fit, track, paths, setup), flights, given, gravity_m_s2)
        apart = tuple(_fitted(flights, flights.are_known & ~turned, samples, setup)) if again[-1] else ()
        # nor is it a wall's what every flight shows
        if not apart:
            turned, thrown, walls_s = np.zeros_like(turned), np.zeros_like(thrown), ()
        chains = apart or chains
    if not chains:
        return FlownTrack(Bounces())
    first = chains[0].fit
    posterior = first.setup_posterior()
    pulls, degrees = posterior.alone.misfit(posterior.mean)
    widening = float(np.sqrt(max(1.0, pulls / degrees))) if degrees else 1.0
    bounces = _with_waves(_bounces(flights, chains, setup, widening), track, segment, first.flights.g_m_s2)
    by_wall = list(zip(bounces.impacts, (turned[:-1] | turned[1:] | thrown).tolist(), strict=True))
    bounces = replace(
        bounces,
        impacts=tuple(replace(one, valid=one.valid and not met) for one, met in by_wall),
        walls_s=walls_s,
        with_walls_s=tuple(one.time_s for one, met in by_wall if met),
    )
    checked = _checked(bounces, track, segment, first.flights)
    outlier = None
    if first.n_setup:
        keys = tuple(one.key for one in first.unknowns.inputs)
        outlier = setup_outlier(SetupChiSquare.of_paths(first), keys, setup)
    return FlownTrack(without_checks_by_walls(checked), chains, widening, None if outlier is None else outlier.finding)


def _located(fit: FittedPaths, track: Track, paths: PathLengths, setup: Setup) -> Track:
    """Return a track located with the setup as flights found it."""
    model, values = PathModel(setup, fit.unknowns), fit.values[: fit.n_setup]
    position_m = model.places(values, np.where(paths.valid, paths.change_m, np.nan))
    return replace(track, position_m=position_m, valid=track.valid & np.isfinite(position_m).all(axis=0))


def _means(paths: PathLengths, segment: Segment, sample_rate_hz: float) -> PathSamples:
    """Return means of the paths over the motion; NaN where one is not known."""
    size, part = max(1, round(PATHS.mean_s * sample_rate_hz)), slice(segment.first, segment.last)
    change_m = np.where(paths.valid[:, part], paths.change_m[:, part], np.nan)
    return PathSamples(block_means(paths.time_s[part], size), block_means(change_m, size))


def _fitted(flights: TrackFlights, known: BoolArray, samples: PathSamples, setup: Setup) -> Iterator[FlightChain]:
    """Yield runs of known flights with the impacts between them, each fitted with what those before say they share."""
    unknowns = SetupUnknowns.of(setup)
    model, prior = PathModel(setup, unknowns), SharedPrior.of(unknowns)
    seen, half_s = np.isfinite(samples.change_m).all(axis=0), 0.5 * PATHS.mean_s
    for first, last in _runs(known):
        begin_s, end_s = flights.begin_s[first:last], flights.end_s[first:last]
        inside = (samples.time_s[:, None] >= begin_s + half_s) & (samples.time_s[:, None] <= end_s - half_s)
        used = seen & inside.any(axis=1)
        if (inside[seen].sum(axis=0) < PATHS.min_means).any():
            continue
        start = Flights(
            float(begin_s[0]) if first == 0 else float(flights.first_s[first]),
            flights.start_m[first],
            float(prior.mean[-3]),
            float(prior.mean[-2]),
            float(prior.mean[-1]),
            flights.velocity_m_s[first:last],
            flights.impact_s[first : last - 1],
        )
        try:
            # receivers at one place determine none: the steps grow beyond all numbers
            with np.errstate(over="raise"):
                fit = fit_paths(PathSamples(samples.time_s[used], samples.change_m[:, used]), start, model, prior)
        except (np.linalg.LinAlgError, FloatingPointError):
            continue
        if not np.isfinite(fit.values).all() or np.abs(fit.flights.impact_s - start.impact_s).max(initial=0.0) > (
            TRACKS.largest_shift_s
        ):
            continue
        prior = fit.shared_posterior()
        yield FlightChain(first, fit)


def _runs(known: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield begin and end of runs of flights, two to `max_flights` of them; neighbours share a flight."""
    begin = 0
    for number in range(1, known.size + 1):
        ends = number == known.size or not known[number]
        if ends or number - begin == PATHS.max_flights:
            if known[begin] and (number - begin > 1 or begin == 0):
                yield begin, number
            begin = number if ends else number - 1
        if number < known.size and not known[begin]:
            begin = number


def _bounces(flights: TrackFlights, chains: tuple[FlightChain, ...], setup: Setup, widening: float) -> Bounces:
    """Return the bounces of fitted flights; impacts beside others have no speeds."""
    count = flights.impact_s.size
    time_s, velocity = flights.impact_s.copy(), np.full((count, 6), np.nan)
    covariance = np.full((count, 6, 6), np.nan)
    for chain in chains:
        values, slopes = chain.fit.velocities()
        time_s[chain.impacts], velocity[chain.impacts] = chain.fit.flights.impact_s, values
        covariance[chain.impacts] = widening**2 * (slopes @ chain.fit.covariances()[1] @ slopes.swapaxes(1, 2))
    known = np.isfinite(velocity).all(axis=1)
    floor = normal_of_velocities(setup, velocity[known], covariance[known])
    unknown = float("nan")
    impacts = []
    for at, own, spread in zip(time_s.tolist(), velocity, covariance, strict=True):
        into, out = -float(own[:3] @ floor.normal), float(own[3:] @ floor.normal)
        # speeds along the normal have no sign left to lose: anything else, and what is not known, is no rebound
        if into > 0.0 and out > 0.0:
            impacts.append(bounce_at(at, own, spread, floor, OF_PATHS))
        else:
            impacts.append(Bounce(at, into, out, unknown, unknown, OF_PATHS, valid=False))
    x, y, z = floor.normal.tolist()
    given = "normal" in setup.floor.model_fields_set
    velocities = VelocitiesAtImpacts(time_s, velocity[:, :3], velocity[:, 3:], covariance, floor.slope_variance)
    return Bounces(
        tuple(impacts),
        _fall(chains[0], floor, widening, setup),
        (x, y, z),
        None if given or not known.any() else floor.u_tilt_deg,
        _braked(chains[-1].fit, setup),
        velocities=velocities,
    )


def _with_waves(bounces: Bounces, track: Track, segment: Segment, gravity_m_s2: float) -> Bounces:
    """Return the bounces with what waves in the track that are as long as a flight is high may do to e and g."""
    part, normal = slice(segment.first, segment.last), np.asarray(bounces.normal)
    valid = track.valid[part]
    height = (normal @ track.position_m[:, part])[valid]
    u_m = np.sqrt(normal**2 @ track.u_position_m[:, part] ** 2)[valid]
    # the third difference has none of what is smooth; its median none of gaps and impacts
    noise_m = robust_sd(np.diff(height, 3)) / np.sqrt(THIRD_DIFFERENCE_GAIN)
    waves_m = float(np.sqrt(max(float(median(u_m)) ** 2 - noise_m**2, 0.0)))
    impacts = []
    for one in bounces.impacts:
        rebound_m = one.speed_after_m_s**2 / (2.0 * gravity_m_s2 * float(normal[2]))
        u_e = np.hypot(one.u_e, TRACKS.waves_in_rebounds * one.e * waves_m / max(rebound_m, 1e-9))
        impacts.append(replace(one, u_e=float(u_e), valid=one.valid and bool(u_e < FLIGHTS.usable_u_e)))
    fall = bounces.free_fall
    if fall is not None:
        fallen_m = abs(fall.parabola[0] - fall.release_height_m) if np.isnan(fall.drop_height_m) else fall.drop_height_m
        u_g = np.hypot(fall.u_g_m_s2, gravity_m_s2 * waves_m / max(fallen_m, 1e-3))
        fall = replace(fall, u_g_m_s2=float(u_g))
    return replace(bounces, impacts=tuple(impacts), free_fall=fall)


def _fall(chain: FlightChain, floor: FloorNormal, widening: float, setup: Setup) -> FreeFall | None:
    """Return the first fall with g and its u where the setup is held; None where the first flight is no fall."""
    fit = chain.fit
    if chain.first > 0:
        return None
    g, _, held = fit.without_g()
    release_m = np.asarray(setup.tracer.release_position_m) + fit.unknowns.by_release @ fit.values[: fit.n_setup]
    u_g = widening * float(np.sqrt(held[fit.gravity_place, fit.gravity_place]))
    return fall_of(fit.flights, float(fit.samples.time_s[-1]), floor.normal, (g, u_g), release_m)


def _braked(fit: FittedPaths, setup: Setup) -> float | None:
    """Return k of the drag where it is that of no metal sphere, and the setup says nothing of its density; else None.

    Air on a sphere of metal is known; a plastic one nobody named is braked ten times as much.
    """
    if setup.tracer.density_kg_m3 is not None:
        return None
    k_1_m, metal_1_m = float(fit.flights.drag_1_m), TRACKS.much_drag * fit.unknowns.drag.k_1_m
    covariance, _ = fit.covariances()
    u = float(np.sqrt(covariance[fit.drag_place, fit.drag_place]))
    return k_1_m if k_1_m - TRACKS.sure_of_drag * u > metal_1_m else None


def _checked(bounces: Bounces, track: Track, segment: Segment, flights: Flights) -> Bounces:
    """Return the bounces with e from flight times and heights of the track."""
    normal, part = np.asarray(bounces.normal), slice(segment.first, segment.last)
    time, height = track.time_s[part], normal @ track.position_m[:, part]
    known = track.valid[part] & np.isfinite(height)
    along = flights.g_m_s2 * float(normal[2])
    return cross_check(bounces, time[known], height[known], along, flights.drag_1_m, flights.slow_m_s)
