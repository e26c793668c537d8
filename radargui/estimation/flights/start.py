"""A drop begun blind: onset, fall, and impact after impact from what release and gravity foretell (method 4)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from radargui.estimation.flights.drop_model import (
    DropModel,
    Evaluation,
    Parts,
    basis_of,
    evaluate,
    minimise,
    robust_cost,
    with_last_flight,
)
from radargui.estimation.forward.bins import Bins
from radargui.estimation.forward.signal_model import EVERY, nodes_of, waves_at
from radargui.model.arrays import FloatArray
from radargui.model.finding import Finding, refuse
from radargui.motion.flights import FlightLayout, Flights


@dataclass(frozen=True, slots=True)
class DropStartSettings:
    """How a drop is begun; lengths in seconds, powers in squared amplitudes of the wave.

    Attributes
    ----------
    bin_s
        Of the means: 1/7 fringe at 2.5 m/s, of which two nodes keep a wave to 1e-4.
    sigma
        No bin counts as better known while one is far from the minimum.
    n_functions
        Of the height, for amplitudes and offsets: one tells least wrongly where the sphere goes next, two follow the
        waves of a wall near by.
    deep_m
        How far below the release a floor is sought that nothing has told of yet.
    rest_s
        Of the rest that is looked at: offsets and the phase at release.
    first_s
        Of the fall that the onset is sought on: 3 cm, two fringes.
    onset_early_s, onset_late_s, onset_step_s
        The onset is sought from so much before to so much after the one that was seen: half a step is a quarter of
        a fringe at the end of the first piece.
    tried
        So many of the best onsets are fitted.
    growth
        By which share the fitted piece grows: what it foretells is then right to a fraction of a radian.
    lost
        Power of the residual of a bin above which the sphere is not where it was foretold.
    lost_s
        How long it must stay so.
    impact_early_s, impact_late_s, impact_step_s
        An impact is sought from so much before to so much after the departure that was seen.
    rebound_step
        Of the speed after it over that before.
    seen_s
        How long after an impact a rebound is looked at.
    min_rebound_m_s
        A slower one is not followed: its flight is 20 ms long and 0.5 mm high.
    longest_share
        Of its length that a flight is fitted to: until just before it lands.
    beside_s
        Before an impact this much is looked at with what follows.
    landed_early_s
        A fall that ends dead is fitted until so long before it lands: where it does is known to half a millisecond,
        and a bin reaches as far.
    fully_fitted
        With so many flights all unknowns are fitted anew after each; further flights by themselves, then all.
    stray_s, max_strays
        Where no bounce explains that the sphere is lost, this much more is fitted, so often at most.
    min_gap_m, below_m
        The floor is at least so far below the centre of the sphere; one that is not is begun again so far below.
    longest_s
        No drop takes longer.
    """

    bin_s: float = 1e-3
    sigma: float = 0.06
    n_functions: tuple[int, ...] = (1, 2)
    deep_m: float = 0.2
    rest_s: float = 0.05
    first_s: float = 0.08
    onset_early_s: float = 0.04
    onset_late_s: float = 0.008
    onset_step_s: float = 0.004
    tried: int = 2
    growth: float = 0.25
    lost: float = 0.15
    lost_s: float = 0.004
    impact_early_s: float = 0.006
    impact_late_s: float = 0.002
    impact_step_s: float = 0.0005
    rebound_step: float = 0.04
    seen_s: float = 0.015
    min_rebound_m_s: float = 0.1
    longest_share: float = 0.96
    beside_s: float = 0.004
    landed_early_s: float = 0.001
    fully_fitted: int = 3
    stray_s: float = 0.005
    max_strays: int = 6
    min_gap_m: float = 0.0025
    below_m: float = 0.03
    longest_s: float = 3.0


START = DropStartSettings()


@dataclass(frozen=True, slots=True)
class DropStart:
    """A drop as far as it could be followed.

    Attributes
    ----------
    model, unknowns
        Of a start: every way over the floor by itself.
    at
        What it makes of the samples followed.
    end_s
        Until when the last flight was followed: just before it lands.
    why
        Why it could not be begun, or not be followed to the end; None where it was.
    landed_s
        When the first fall landed, where no rebound followed that could be seen; else None.
    """

    model: DropModel
    unknowns: FloatArray
    at: Evaluation
    end_s: float
    why: Finding | None = None
    landed_s: float | None = None
    trace: tuple[str, ...] = field(default=(), repr=False)

    @property
    def flights(self) -> Flights:
        """The flights found."""
        return Flights.of(self.at.values.flights)


def part_of(bins: Bins, first_s: float, last_s: float) -> Bins:
    """Return the bins between two times."""
    return bins.of(np.flatnonzero((bins.time_s > first_s) & (bins.time_s < last_s)))


def start_drop(model: DropModel, bins: Bins) -> DropStart:
    """Follow a drop from its rest.

    Parameters
    ----------
    model
        Of a start, with one flight from the onset that was seen.
    bins
        Means of `bin_s` of the record.
    """
    drop = _Followed(replace(model, min_sigma=START.sigma), bins)
    impact = drop.fall()
    while impact is not None and drop.rebound(impact):
        impact = drop.next_impact()
    return DropStart(drop.model, drop.unknowns, drop.at, drop.end_s, drop.why, drop.landed_s, tuple(drop.trace))


class _Followed:
    """A drop on the way: as far as it is fitted, and what comes next."""

    def __init__(self, model: DropModel, bins: Bins) -> None:
        seen = float(model.mean.flights[0])
        self.bins = bins
        self.why: Finding | None = None
        self.landed_s: float | None = None
        self.trace: list[str] = []
        self.begin_s = seen - START.onset_early_s - START.rest_s
        self.end_s = seen + START.first_s
        self.model, self.unknowns, self.at = _with_onset(model, bins, self.begin_s, self.end_s)
        onset = float(self.at.values.flights[0])
        self.last_s = min(float(bins.last_s[-1]), onset + START.longest_s)
        self._say(f"onset {onset:.4f} power {_power(self.at).mean():.4f}")

    def fall(self) -> _Impact | None:
        """Follow the fall to its end; return the impact there, None where the record ends or nothing falls."""
        onset = float(self.at.values.flights[0])
        if _power(self.at).mean() > START.lost:
            self.why = refuse("flights_not_begun")
            return None
        for _ in range(START.max_strays):
            lost = None
            while lost is None and self.end_s < self.last_s:
                further = min(onset + (self.end_s - onset) * (1.0 + START.growth), self.last_s)
                lost = self._lost_after(self.end_s, further)
                self._fit(further if lost is None else lost - START.bin_s)
                if lost is not None:
                    # whether what was foretold had gone astray, or the sphere: what is fitted so far foretells anew
                    again = self._lost_after(self.end_s, min(lost + 0.01, self.last_s))
                    if again is None or again > lost + 0.003:
                        self.end_s, lost = lost, None
            self._say(f"fall until {self.end_s:.4f}")
            if lost is None:
                return None
            found = self._impact(lost)
            if found.power < START.lost:
                return found
            # no bounce explains it: a wave that is not known yet had led the prediction astray
            self._fit(lost + START.stray_s)
        self.why = refuse("flights_lost")
        return None

    def rebound(self, impact: _Impact) -> bool:
        """Follow the flight after an impact until just before it lands; return whether there is one to follow."""
        if impact.power > START.lost:
            self.why = refuse("rebound_unexplained")
            return False
        if impact.rebound_m_s < START.min_rebound_m_s and len(self.at.values.flights) == _ONE_FLIGHT:
            impact = self._landing(impact)
            self.landed_s = impact.time_s if impact.rebound_m_s < START.min_rebound_m_s else None
        if impact.rebound_m_s < START.min_rebound_m_s:
            return False
        kept = self.model, self.unknowns, self.at, self.end_s
        before = Flights.of(self.at.values.flights).velocity_at(np.array([impact.time_s - 1e-6]))[:, 0]
        velocity = np.array([before[0], before[1], impact.rebound_m_s])
        self.model, values = self.model.with_flight(self.at.values, impact.time_s, velocity)
        number, seen = Flights.of(values.flights).layout.n_flights, START.seen_s
        # twice as long each time: what is fitted foretells as much again to a fraction of a fringe
        while seen + START.bin_s < (flown := self._flown(values)):
            seen = min(2.0 * seen, flown)
            begin = _last_flight(values)[0]
            part = part_of(self.bins, begin - START.beside_s, begin + seen)
            one = self.model.of_bins(part, values, foretold=True)
            _, own = with_last_flight(one, one.unknowns(values), self.at.coefficients)
            values = own.values
        if not _rebounds(values):
            self.model, self.unknowns, self.at, self.end_s = kept
            return False
        begin = _last_flight(values)[0]
        end = begin + self._flown(values)
        if number <= START.fully_fitted:
            self._fit(end, values)
        else:
            self.model = self.model.of_bins(part_of(self.bins, begin - START.beside_s, end), values, foretold=True)
            self.unknowns, self.end_s = self.model.unknowns(values), end
            self.at = evaluate(self.model, self.unknowns, coefficients=self.at.coefficients)
        since = self.model.bins.time_s > _last_flight(self.at.values)[0]
        if not _rebounds(self.at.values) or not since.any():
            self.model, self.unknowns, self.at, self.end_s = kept
            return False
        if _power(self.at)[since].mean() > START.lost:
            self.model, self.unknowns, self.at, self.end_s = kept
            self.why = refuse("flight_lost")
            return False
        self._say(f"flight to {end:.4f} power {_power(self.at)[since].mean():.4f}")
        return True

    def _flown(self, values: Parts) -> float:
        """Return how long the last flight is followed, at most: until just before it lands, or the record ends."""
        begin, length = _last_flight(values)
        return min(START.longest_share * length, self.last_s - begin)

    def _landing(self, impact: _Impact) -> _Impact:
        """Return the impact that ends a fall, found anew: a dead one shows as lost late, and what follows bends it."""
        for _ in range(2):
            self._fit(min(self.end_s, impact.time_s - START.landed_early_s))
            impact = self._impact(impact.time_s + START.impact_late_s)
        return impact

    def next_impact(self) -> _Impact | None:
        """Return the impact where the last flight lands; None where the record ends before a rebound shows."""
        begin, length = _last_flight(self.at.values)
        lands = begin + length
        return None if lands > self.last_s - START.seen_s else self._impact(lands + START.impact_late_s)

    def _impact(self, lost_s: float) -> _Impact:
        found = _impact_near(self.model, self.bins, self.at, lost_s)
        self._say(f"impact {found.time_s:.4f} rebound {found.rebound_m_s:.3f} power {found.power:.3f}")
        return found

    def _fit(self, end_s: float, values: Parts | None = None) -> None:
        """Fit all unknowns to the samples until a time."""
        values = self.at.values if values is None else values
        for _ in range(2):
            model = self.model.of_bins(part_of(self.bins, self.begin_s, end_s), values)
            fit = minimise(model, model.unknowns(values), rounds=2, steps=5)
            self.model, self.unknowns, self.at = fit
            self.end_s, values = end_s, self.at.values
            # no floor is above the sphere: another way over it had run away
            shift = self.model.layout.planes.start + 2
            lowest = float(Flights.of(values.flights).position_m(np.array([end_s]))[2, 0]) - START.min_gap_m
            if self.model.plane.foot_m[2] + values.theta[shift] < lowest or len(values.flights) > _ONE_FLIGHT:
                return
            theta = values.theta.copy()
            theta[shift] = lowest - START.below_m - self.model.plane.foot_m[2]
            values = values._replace(theta=theta)

    def _lost_after(self, begin_s: float, end_s: float) -> float | None:
        return _lost_after(self.model, self.bins, self.at, begin_s, end_s)

    def _say(self, sentence: str) -> None:
        self.trace.append(sentence)


_ONE_FLIGHT = FlightLayout(1).size


class _Impact(NamedTuple):
    """An impact as it was found: when, with which speed upwards it leaves, and the power of what is left around it."""

    time_s: float
    rebound_m_s: float
    power: float


def followed_until(end_s: float, values: Parts) -> float:
    """Return until when a drop is followed that was so to `end_s`: no further than to just before it lands."""
    begin, length = _last_flight(values)
    return end_s if len(values.flights) == _ONE_FLIGHT else min(end_s, begin + START.longest_share * length)


def _last_flight(values: Parts) -> tuple[float, float]:
    """Return when the last flight begins, and how long it lasts until it is as high again."""
    flights = Flights.of(values.flights)
    return float(flights.begin_s[-1]), 2.0 * float(flights.velocity_m_s[-1, 2]) / flights.g_m_s2


def _rebounds(values: Parts) -> bool:
    """Return whether the last flight leaves the floor faster than what is followed at least."""
    flights = Flights.of(values.flights)
    return bool(flights.velocity_m_s[-1, 2] > START.min_rebound_m_s)


def _power(at: Evaluation) -> FloatArray:
    """Return the squared residuals of bins in amplitudes, mean over the receivers, shape (n_bins,)."""
    return np.asarray((at.misfit * START.sigma**2).mean(axis=0))


def _with_onset(model: DropModel, bins: Bins, begin_s: float, end_s: float) -> tuple[DropModel, FloatArray, Evaluation]:
    """Return the first piece of the fall from the onset that explains it best."""
    seen = float(model.mean.flights[0])
    shifts = np.arange(-START.onset_early_s, START.onset_late_s + 1e-9, START.onset_step_s)
    part = part_of(bins, begin_s, end_s)
    scanned = []
    for shift in shifts:
        values = model.mean._replace(flights=np.append(seen + shift, model.mean.flights[1:]))
        one = model.of_bins(part, values)
        unknowns = one.unknowns(values)
        at = evaluate(one, unknowns)
        scanned.append((robust_cost(one, unknowns, at), shift, one, unknowns))
    scanned.sort(key=lambda row: row[0])
    # neighbours on the grid, and a second valley where there is one
    tried = [minimise(one, unknowns, rounds=2, steps=6) for _, _, one, unknowns in scanned[: START.tried]]
    return min(tried, key=lambda fit: robust_cost(*fit))


def _foretold(model: DropModel, bins: Bins, at: Evaluation, place: FloatArray) -> FloatArray:
    """Return the power of what is left of bins where the sphere is at places (3, n_channels, 2, n_some, n_bins).

    What is linear stays as it was: the sphere has not moved far from where it was found. Shape (n_some, n_bins).
    """
    part = model.of_bins(bins, at.values, foretold=True)
    n_some, n_bins = place.shape[-2:]
    many = bins.of(np.tile(np.arange(bins.n_bins), n_some))
    fields = part.inputs.sphere
    repeated = replace(
        part.inputs,
        bias=np.zeros((many.n_bins, 0)),
        amplitude_map=np.zeros((many.n_bins, 0)),
        drift=np.zeros((model.delay_s.size, many.n_bins, 0)),
        range_factor=part.inputs.range_factor[:, np.tile(np.arange(bins.n_bins), n_some)],
        antennas=model.setup.antennas(at.values.setup),
        wavenumber=model.setup.wavenumber(at.values.setup),
        sphere=None if fields is None else fields.repeated(n_some),
    )
    many_model = replace(part, bins=many, inputs=repeated, functions=np.tile(part.functions, n_some))
    waves = waves_at(nodes_of(place.reshape(*place.shape[:3], -1)), at.values.theta, model.layout, repeated, EVERY)
    value = (basis_of(many_model, waves, at.values.theta) @ at.coefficients[:, None, :, None])[..., 0]
    away = many.value.reshape(value.shape) - value
    return np.asarray((away**2).mean(axis=(0, 1)).reshape(n_some, n_bins))


def _lost_after(model: DropModel, bins: Bins, at: Evaluation, begin_s: float, end_s: float) -> float | None:
    """Return when the sphere leaves what was foretold of a flight that goes on; None where it does not."""
    part = part_of(bins, begin_s, end_s)
    window = max(1, round(START.lost_s / START.bin_s))
    if part.n_bins < window:
        return None
    times = replace(model, bins=part).node_times()
    place = Flights.of(at.values.flights).position_m(times.ravel()).reshape(3, *times.shape[:2], 1, -1)
    power = _foretold(model, part, at, place)[0]
    mean = np.convolve(power, np.full(window, 1.0 / window), "valid")
    lost = np.flatnonzero(mean > START.lost)
    return float(part.time_s[lost[0]]) if lost.size else None


def _impact_near(model: DropModel, bins: Bins, at: Evaluation, lost_s: float) -> _Impact:
    """Return time and upward speed after an impact near a time, and the power that they leave."""
    flights = Flights.of(at.values.flights)
    early = max(lost_s - START.impact_early_s, float(flights.begin_s[-1]) + 2e-3)
    times = np.arange(early, lost_s + START.impact_late_s, START.impact_step_s)
    part = part_of(bins, early - 2e-3, lost_s + START.seen_s)
    if part.time_s.size == 0 or part.time_s[-1] < lost_s:
        # lost or clipped samples tell nothing
        return _Impact(lost_s, 0.0, np.inf)
    before = flights.velocity_at(times)
    shares = np.arange(0.0, 1.02, START.rebound_step)
    t1, share = (one.ravel() for one in np.meshgrid(np.arange(times.size), shares, indexing="ij"))
    rebound = -share * before[2, t1]
    node = replace(model, bins=part).node_times()
    free = flights.position_m(node.ravel()).reshape(3, *node.shape)
    there = flights.position_m(times)
    since = node[..., None, :] - times[t1][:, None]
    g = flights.g_m_s2
    # it lies where it lands again within what is looked at
    flown = np.minimum(since, (2.0 * rebound / g)[:, None])
    up = rebound[:, None] * flown - 0.5 * g * flown**2
    after = np.stack([there[axis, t1][:, None] + before[axis, t1][:, None] * since for axis in (0, 1)])
    after = np.concatenate([after, (there[2, t1][:, None] + up)[None]])
    place = np.where(since > 0.0, after, free[..., None, :])
    power = _foretold(model, part, at, place).mean(axis=1)
    best = int(np.argmin(power))
    return _Impact(float(times[t1[best]]), float(rebound[best]), float(power[best]))
