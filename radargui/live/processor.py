"""Turn samples into a track while they arrive: causally, in a few microseconds a sample.

Find what speaks against a live track: a receiver off its circle, dead, or equal to another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import Enum

import numpy as np

from radargui.live.map_filter import LATE_S, MapFilter, SlowMotion
from radargui.live.rest_statistics import FALLEN_M, Release
from radargui.live.samples import LiveSamples, Means
from radargui.live.track import LiveEstimate
from radargui.live.trigger import MotionTrigger
from radargui.model.arrays import FloatArray, IntArray, RawArray
from radargui.model.gravity import fall_time_s
from radargui.model.radar import Radar
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS, locate_exact, place_antennas
from radargui.physics.scattering import path_delay
from radargui.signals.fall import vertical_motion
from radargui.signals.fall_signs import FallRule
from radargui.signals.hum import Hum, find_hum
from radargui.signals.noise import MIN_SAMPLES, white_noise_v
from radargui.signals.receiver_check import same_channels

WORST_MISFIT = 0.35
"""In amplitudes, over the last fringes: in 150 motions of the laboratory paths below were wrong by a sixth of a fringe
at the most, and turns were lost above."""
LONG_M, SHORT_M = 0.1, 0.01
"""A receiver whose path changes by less than the second, while that of another one does by the first, shows no motion:
a third of a fringe is what noise and hum make of a dead input. By hand."""
LOUDEST = 0.18
"""Noise of a column in amplitudes, the mean so far in a motion: of eight falls each with echoes of 4 dB at the release
(0.16 to 0.185 at the end), 3 dB (0.18 to 0.20) and 2 dB (0.20 to 0.225) all, seven and four were counted right."""
MIN_COLUMNS = 200
"""That tell it within a tenth. By hand."""
MAX_COLUMNS = 4000
"""After a second it is known. By hand."""
BLOCKS_COMPARED = 3
"""Of a motion, for one cable on two inputs: each has a fringe or more in it."""
PATH_WINDOW_M, PATH_LEAST_M = 7.848e-3, 0.04904
"""Ways of a fall from rest in half a parabola through paths, and in the fall it has to fit (`FallRule`), 80 and 100 ms
on Earth: what is left of the mismatch ripples paths, and a throw is not known before it ends. By hand."""


class Doubts:
    """Watches a motion while it is followed.

    Parameters
    ----------
    setup
        Antennas, release, wavelength.
    rate_hz
        Of the block means.
    """

    def __init__(self, setup: Setup, rate_hz: float) -> None:
        self._n, self._wavelength_m, self._sign = setup.n_receivers, setup.radar.wavelength_m, setup.radar.phase_sign
        self._falls = FallWatch(setup, rate_hz)
        self.begin()

    def begin(self) -> None:
        """Forget the preceding motion, because another one begins."""
        self._compared = 0
        self._n_heard, self._noise_square = 0, np.zeros(self._n)
        self._forget_ends()
        self._falls.begin()

    def _forget_ends(self) -> None:
        self._ends = np.array([[np.inf], [-np.inf]]).repeat(self._n, axis=1)

    def of(
        self, change_m: FloatArray, radius: FloatArray, misfits: Sequence[float], volts: FloatArray,
        rest_v: FloatArray, noise_v: FloatArray,
    ) -> str:  # fmt: skip
        """Return why the next columns cannot be trusted; empty where nothing speaks against them.

        Parameters
        ----------
        change_m
            Change of path length, shape (n_receivers, n).
        radius
            Of corrected I and Q, in amplitudes, shape (n_receivers, n).
        misfits
            `MapFilter.misfit` of each receiver, after them.
        volts, rest_v
            Block means of the channels, in these columns and at rest, shape (2 n_receivers, n).
        noise_v
            Standard deviation of one of them at rest, shape (2 n_receivers,).
        """
        worst = int(np.argmax(misfits))
        if misfits[worst] > WORST_MISFIT:
            return f"receiver {worst + 1} shows no circle"
        # a fringe or more far off the circle: the four that the misfit remembers would be late
        low, high = change_m.min(axis=1), change_m.max(axis=1)
        far = np.sqrt(((radius - 1.0) ** 2).mean(axis=1))
        if far.max() > WORST_MISFIT and (high - low).max() > self._wavelength_m:
            return f"receiver {int(np.argmax(far)) + 1} shows no circle"
        self._ends = np.stack([np.fmin(self._ends[0], low), np.fmax(self._ends[1], high)])
        span = self._ends[1] - self._ends[0]
        if span.max() > LONG_M:
            self._forget_ends()
            if span.min() < SHORT_M:
                return f"receiver {int(np.argmin(span)) + 1} shows no motion"
        if faint := self._faint(radius):
            return faint
        if backwards := self._falls.push(change_m):
            return f"receiver {backwards[0] + 1} falls upwards: are I and Q swapped?"
        if self._compared < BLOCKS_COMPARED and (high - low).max() > self._wavelength_m:
            self._compared += 1
            for one, other in same_channels(volts, noise_v, rest_v, self._sign):
                return f"receivers {one // 2 + 1} and {other // 2 + 1} have one cable"
        return ""

    def _faint(self, radius: FloatArray) -> str:
        """Return which receivers have too much noise for their fringes to be counted, so far in this motion."""
        count = radius.shape[1]
        if count >= MIN_SAMPLES and self._n_heard < MAX_COLUMNS:
            self._n_heard += count
            self._noise_square += count * white_noise_v(radius) ** 2
        if self._n_heard < MIN_COLUMNS:
            return ""
        noise = np.sqrt(self._noise_square / self._n_heard)
        worst = int(np.argmax(noise))
        return f"receiver {worst + 1} is too weak against its noise" if noise[worst] > LOUDEST else ""


class FallWatch:
    """Watches the paths of a track while it is followed, for receivers that show a fall upwards.

    Parameters
    ----------
    setup
        Antennas, release, wavelength.
    rate_hz
        Of the path lengths.
    """

    def __init__(self, setup: Setup, rate_hz: float) -> None:
        self._rule = FallRule(setup, rate_hz, PATH_WINDOW_M, PATH_LEAST_M)
        self._rate_hz, self._rad_per_m = rate_hz, 2.0 * np.pi / setup.radar.wavelength_m
        self._least = round(fall_time_s(PATH_LEAST_M, self._rule.gravity_m_s2) * rate_hz) + 1
        self.begin()

    def begin(self) -> None:
        """Begin another motion. Receivers that fell downwards once are not tested again."""
        self._held = np.empty((0, 0))

    def push(self, change_m: FloatArray) -> tuple[int, ...]:
        """Take the next changes of path length, shape (n_receivers, n); return the receivers that fell upwards."""
        if not self._rule.is_decisive:
            return ()
        held = np.concatenate([self._held, change_m], axis=1) if self._held.size else change_m
        self._held = held[:, -self._least :]
        if held.shape[1] < self._least:
            return ()
        rule = self._rule
        phase = self._rad_per_m * held
        signs = rule.signs(vertical_motion(phase, self._rate_hz, rule.window, rule.rad_per_m, rule.gravity_m_s2))
        # wires are not exchanged while it runs
        rule.is_decisive = signs is not None
        return () if signs is None else tuple(np.flatnonzero(signs.backwards).tolist())


BLIND_S = 0.002
"""Of samples that are no numbers: a fall of half a metre passes a quarter of a fringe. By hand."""
BEFORE_MOTION_S = 0.08
"""The trigger finds a motion late: so much before it is not taken for rest (a fall of 30 mm lasts as long)."""
REST_S = 0.2
"""Averaged for the phase of the rest: whole periods of 50 and of 60 Hz."""
REST_MEMORY_S = 1.8
"""Kept of the rest: the hum is measured on up to a second of it, `REST_S` and what was told late come off. By hand."""
LONGEST_START_S = 20.0
"""Motion kept while the first 1.5 fringes are not complete; after more nobody knows where it is. By hand."""
START_COLUMNS = 8000
"""The first fringes are looked for in so many of them, the last 2 s of a fast motion: more cost more time."""
LATEST_S = 0.5
"""What has waited so long for the first fringes is shown as unknown. By hand."""
SETTLED_S = 0.3
"""So long quiet is settled: an apex and the turn of a swing are quiet for less. By hand."""
SETTLED_M = 2e-3
"""And within this: noise of 20 dB is a quarter of it. By hand."""
AS_BEFORE = 0.2
"""Share of what a motion changed a voltage by: within it the voltage of the rest after is that of the one before."""
AT_RELEASE_M = 0.012
"""So near the release a tracer is back there, and so near its lowest place on the floor. By hand."""
STRAYED_M = 0.04
"""A track that says it is farther from the release than this has lost turns, or it hangs elsewhere. By hand."""
LOST = "samples were lost"


class LiveMemory:
    """Holds one filter a receiver; empty until a live processor has used it. One acquisition at a time may."""

    def __init__(self) -> None:
        self._filters: list[MapFilter] = []
        self._radar: Radar | None = None

    @property
    def is_warm(self) -> bool:
        """Whether a run can be followed from its first sample."""
        return bool(self._filters) and all(follower.started for follower in self._filters)

    def forget(self) -> None:
        """Forget all that was learned, because it is wrong."""
        self._filters = []

    def filters(self, setup: Setup) -> list[MapFilter]:
        """Return the filters for a setup; they are new if those kept belong to another radar."""
        if len(self._filters) != setup.n_receivers or setup.radar != self._radar:
            rad_per_m = 2.0 * np.pi / setup.radar.wavelength_m
            self._filters = [MapFilter(rad_per_m) for _ in range(setup.n_receivers)]
            self._radar = setup.radar
        return self._filters


class _Mode(Enum):
    RESTING = "at the release"
    STARTING = "moving, the first fringes are not complete"
    FOLLOWING = "moving, or resting elsewhere"
    LOST = "samples are missing while it moves: where it is cannot be known"


class LiveProcessor:
    """The causal way from raw samples to positions.

    Samples are averaged to about 4 kHz, the multiplexer skew is interpolated away, and the hum learned at rest is taken
    off. Each receiver is corrected by a `MapFilter`: at once if earlier runs have taught it, otherwise as soon as 1.5
    fringes have passed. The tracer is at its release when the first samples come, when `at_release` says so, and when
    it has come to rest within 12 mm of it. Where the setup states the polarisation, the phase that the sphere scatters
    with is subtracted from the path.

    Parameters
    ----------
    setup
        Geometry and release position.
    digitisation
        How the samples to be pushed were taken.
    memory
        The filters that earlier runs of the session have taught; they go on learning. None: begin without any
        knowledge.
    """

    def __init__(self, setup: Setup, digitisation: Digitisation, memory: LiveMemory | None = None) -> None:
        self._setup = setup
        self._digitisation = digitisation
        self._memory = LiveMemory() if memory is None else memory
        self._antennas = place_antennas(setup)
        self._locates = setup.n_receivers >= MIN_RECEIVERS
        self._delay = path_delay(setup)
        self._release_m = np.array(setup.tracer.release_position_m)
        self._filters = self._memory.filters(setup)
        self._trigger = MotionTrigger(digitisation, setup.recording.threshold)
        self._samples = LiveSamples(digitisation, setup.daq, setup.radar.phase_sign)
        self._slow = SlowMotion(self._samples.rate_hz, digitisation.sample_rate_hz, setup.recording.threshold)
        self._hum: Hum | None = None
        self._hum_from_s = 0.0
        self._past = self._samples.nothing()
        self._pending = self._samples.nothing()
        self._n_reported = 0
        self._n_quiet = 0
        self._doubts = Doubts(setup, self._samples.rate_hz)
        self._doubt = ""
        self._rest = self._samples.nothing()
        self._noise_v = np.full(digitisation.n_channels, np.nan)
        # no gap yet
        self._n_since_gap = self._columns(LATE_S)
        self._why_gap = LOST
        self._settling_m = np.full(3 if self._locates else setup.n_receivers, np.nan)
        self._release = Release()
        self._begin_at_release()

    def at_release(self) -> None:
        """Begin at the release: the tracer hangs at its release and rests, as it does when a hand has put it back.

        A tracer that was followed down to its lowest place, where it now lies, is on the floor: the hand has not come
        yet, and the tracer is followed further. If it was followed to another place, positions count from here as if it
        were the release, and the estimate says so.
        """
        follows = self._mode is _Mode.FOLLOWING
        if follows and self._lies_on_floor():
            return
        if self._mode is _Mode.STARTING and not self._looks_as_before():
            self._release.lose(seen=False)
        away_m = float(np.linalg.norm(self._position_m - self._release_m))
        if self._release.hang_up(strayed=follows and self._locates and away_m > STRAYED_M):
            self._begin_at_release()

    def fallen(self) -> None:
        """Note that a drop has ended: a tracer that was lost in it lies somewhere until a hand has moved it."""
        self._release.fallen()

    def _begin_at_release(self) -> None:
        self._mode, self._doubt = _Mode.RESTING, ""
        self._slow.clear()
        self._position_m = self._release_m.copy()
        self._lowest_m = float(self._release_m[2])

    def _lies_on_floor(self) -> bool:
        height_m = float(self._position_m[2])
        return height_m < self._release_m[2] - FALLEN_M and height_m < self._lowest_m + AT_RELEASE_M

    def push(self, samples: RawArray, first_index: int | None = None) -> LiveEstimate:
        """Take the next samples, shape (n_channels, n); at a jump to `first_index` samples were lost."""
        # turns that went by in a gap cannot be counted (method 2): only a rest shows where it is again
        lost, why = self._samples.jump(first_index), LOST
        if lost:
            self._past = self._samples.nothing()
            self._slow.clear()
        elif (unknown := self._samples.unknown(samples)) > BLIND_S * self._digitisation.sample_rate_hz:
            lost, why = unknown, "a channel gave no numbers"
        if lost:
            self._n_since_gap, self._why_gap = 0, why
            # it may have fallen meanwhile, and come to rest
            self._release.began_anew |= lost > BEFORE_MOTION_S * self._digitisation.sample_rate_hz
            if self._mode is not _Mode.RESTING:
                self._lose(why)
        fast = self._trigger.push(samples).moving
        new = self._samples.push(samples)
        slow = self._slow.push(new.volts)
        moving = fast or slow
        # where it is followed a slow motion is seen anyhow
        restless = fast if self._mode is _Mode.FOLLOWING else moving
        self._n_quiet = 0 if restless else self._n_quiet + new.count
        # what is told late needs a rest from before
        knows_rest = self._past.count >= self._columns(LATE_S + REST_S)
        if self._mode is _Mode.RESTING and slow and not self._slow.has_rested:
            self._lose("it moved, or the voltages drifted, as the first samples came")
        elif self._mode is _Mode.RESTING and (fast or (slow and knows_rest)):
            # what moves so soon after a gap may have left in it
            late = self._columns(BEFORE_MOTION_S if fast else LATE_S)
            self._leave(late) if self._n_since_gap >= late else self._lose(self._why_gap)
        self._n_since_gap += new.count
        estimate = self._estimate_by_mode(new, fast=fast)
        # only what rests now can teach the phase of the rest, and no rest before it
        rests = self._mode is _Mode.RESTING or not moving
        past = self._past.joined(new) if rests else self._samples.nothing()
        self._past = past.part(-self._columns(REST_MEMORY_S), None)
        self._release.goes(float(np.linalg.norm(self._position_m - self._release_m)))
        self._lowest_m = min(self._lowest_m, float(self._position_m[2]))
        # the operator hangs the sphere up again by hand: no command says when
        if self._mode is not _Mode.RESTING and self._is_back(estimate):
            # after a gap nobody knows where it rests: it counts from there as if that were its release, and says so
            self._begin_at_release()
            self._doubt = self._doubt_at_rest
        # shown beside the recorded Q
        q = self._setup.radar.phase_sign * estimate.q
        shaken = (int(new.index[-1]), self._trigger.shaking) if new.count else None
        return replace(estimate, q=q, began_anew=self._release.began_anew, doubt=self._doubt, shaken=shaken)

    def _estimate_by_mode(self, new: Means, *, fast: bool) -> LiveEstimate:
        if new.count == 0 or self._mode is _Mode.LOST:
            return self._unknown(new.index, moving=fast)
        if self._mode is _Mode.RESTING:
            self._doubt = self._doubt_at_rest
            return self._resting(new).without_place() if self._doubt else self._resting(new)
        # where it is followed a slow motion is seen, and quiet is soon told; before, all that moves is a motion
        return self._starting(new, fast=fast) if self._mode is _Mode.STARTING else self._following(new, moving=fast)

    @property
    def _doubt_at_rest(self) -> str:
        """Return why rest cannot be told from motion: a fall would not be seen in these signals."""
        return f"a motion would be lost in {self._trigger.disturbance}" if self._trigger.objection else ""

    def _lose(self, why: str, *, seen: bool = True) -> None:
        self._mode, self._doubt = _Mode.LOST, why
        self._release.lose(seen=seen)

    def _leave(self, late: int) -> None:
        """Begin a motion, `late` columns after it began: learn the hum, the phase and the noise of the rest before."""
        rest = self._past.part(0, max(self._past.count - late, 0))
        # at rest hum is all that oscillates; in motion it could be a slow Doppler
        self._hum = None
        self._rest, self._noise_v = rest, np.zeros(rest.volts.shape[0])
        if rest.count > 1:
            self._noise_v = white_noise_v(rest.volts)
            self._hum_from_s, whole = float(self._time_s(rest)[0]), (slice(0, rest.count),)
            self._hum = find_hum(rest.volts, self._samples.rate_hz, whole, self._noise_v)
        quiet = self._without_hum(rest.part(-self._columns(REST_S), None))
        is_known = quiet.shape[1] > 1
        for follower, pair in zip(self._filters, _pairs(quiet), strict=True):
            follower.rest(*(pair.mean(axis=1), float(pair.std(axis=1).mean())) if is_known else (None, None))
        self._doubts.begin()
        # reported already as rest, but the motion may have begun there
        self._pending = self._past.part(-late, None)
        self._n_reported = self._pending.count
        # what was said of the rest is not true of a motion that is seen
        self._mode, self._doubt = _Mode.STARTING, ""

    def _resting(self, new: Means) -> LiveEstimate:
        z = [follower.at_rest(pair) for follower, pair in zip(self._filters, _pairs(new.volts), strict=True)]
        i, q = np.stack(z, axis=1)
        place = self._release_m if self._locates else np.full(3, np.nan)
        return LiveEstimate(
            new.index, i, q, np.zeros(i.shape), np.repeat(place[:, None], new.count, axis=1), moving=False
        )

    def _starting(self, new: Means, *, fast: bool) -> LiveEstimate:
        """Wait for 1.5 fringes of every receiver, then return the estimates of all waiting samples at once."""
        pending = self._pending = self._pending.joined(new)
        # a slow one is thinned, a fast one is looked for where it is
        step = max(1, -(-pending.count // START_COLUMNS))
        shown = self._without_hum(pending.part(-START_COLUMNS, None) if fast else pending.thinned(step))
        warm = self._memory.is_warm
        # each is asked: what is said of those that have not shall be true
        started = [follower.start(pair) for follower, pair in zip(self._filters, _pairs(shown), strict=True)]
        if all(started):
            self._mode, self._doubt = _Mode.FOLLOWING, ""
            self._pending = self._samples.nothing()
            return self._following(pending, moving=fast, skip=self._n_reported, learn=warm)
        # from its first sample on: where the turns before are not there, none after them can be counted
        if pending.count > self._columns(LONGEST_START_S):
            self._lose("it moved for long by less than a fringe", seen=False)
            return self._unknown(pending.index[self._n_reported :], moving=True)
        if self._n_reported < pending.count - self._columns(LATEST_S):
            missing = [str(number) for number, one in enumerate(started, 1) if not one]
            self._doubt = f"no whole circle yet of receiver {', '.join(missing)}"
        due = max(pending.count - self._columns(LATEST_S), self._n_reported)
        late = pending.index[self._n_reported : due]
        self._n_reported = due
        return self._unknown(late, moving=True)

    def _following(self, new: Means, *, moving: bool, skip: int = 0, learn: bool = True) -> LiveEstimate:
        pairs = _pairs(self._without_hum(new))
        followed = [follower.follow(pair, learn=learn) for follower, pair in zip(self._filters, pairs, strict=True)]
        i, q, change = np.stack([(*z, change) for z, change in followed], axis=1)[..., skip:]
        misfits = [follower.misfit for follower in self._filters]
        rest = self._rest.volts, self._noise_v
        doubt = self._doubts.of(change, np.hypot(i, q), misfits, new.volts, *rest) if change.size else ""
        if doubt:
            # turns may be lost already, and are not found again before the next rest; maps that have gone astray
            # would lead the next motion astray as well
            self._memory.forget()
            self._filters = self._memory.filters(self._setup)
            self._lose(doubt, seen=False)
            return self._unknown(new.index[skip:], moving=moving)
        return LiveEstimate(new.index[skip:], i, q, *self._locate(change), moving)

    def _locate(self, change_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the change of path length without the sphere's own, and the position."""
        n = change_m.shape[1]
        if not self._locates or n == 0:
            return change_m, np.full((3, n), np.nan)
        # two places fit three path lengths: the solution near the last one is the sphere
        start = np.repeat(self._position_m[:, None], n, axis=1)
        position = locate_exact(change_m, self._antennas, self._release_m, start)
        if self._delay is not None:
            # one step is enough: the delay changes by a thousandth of what the place does
            # a sphere is no point: its phase of scattering changes with the bistatic angle (method 3)
            change_m = change_m - self._delay.at(position)
            position = locate_exact(change_m, self._antennas, self._release_m, position)
        # where the next solution starts; lost altogether, the release is the best guess there is
        known = np.flatnonzero(np.isfinite(position).all(axis=0))
        self._position_m = position[:, known[-1]] if known.size else self._release_m.copy()
        return change_m, position

    def _unknown(self, index: IntArray, *, moving: bool) -> LiveEstimate:
        nothing = np.full((self._setup.n_receivers, index.size), np.nan)
        return LiveEstimate(index, nothing, nothing, nothing, np.full((3, index.size), np.nan), moving)

    def _is_back(self, estimate: LiveEstimate) -> bool:
        """Whether the tracer has been quiet for a while where a run can start."""
        if self._mode is _Mode.FOLLOWING and estimate.index.size:
            # a hand that comes to its end is quiet for the trigger long before
            place = estimate.position_m.mean(axis=1) if self._locates else estimate.change_m.mean(axis=1)
            if not np.abs(place - self._settling_m).max() < SETTLED_M:
                self._settling_m, self._n_quiet = place, 0
        if self._n_quiet < self._columns(SETTLED_S):
            return False
        if self._mode is _Mode.STARTING and not self._looks_as_before():
            # it was not seen to go, and lies anywhere: voltages as before would say that it is back
            self._release.lose(seen=False)
        if self._mode is not _Mode.FOLLOWING:
            return True
        if estimate.index.size == 0:
            return False
        if self._locates:
            return bool(np.linalg.norm(estimate.position_m[:, -1] - self._release_m) < AT_RELEASE_M)
        # without a position the path lengths have to do
        return bool((np.abs(estimate.change_m[:, -1]) < AT_RELEASE_M).all())

    def _looks_as_before(self) -> bool:
        """Whether the voltages of this rest are those of the rest before, as far as the motion between tells."""
        rest = self._past.part(-self._columns(REST_S), None)
        if rest.count == 0:
            return False
        now = self._without_hum(rest).mean(axis=1)
        before = np.concatenate([follower.rest_v for follower in self._filters])
        far = np.ptp(self._without_hum(self._pending), axis=1)
        return bool((np.abs(now - before) < AS_BEFORE * far).all())

    def _without_hum(self, means: Means) -> FloatArray:
        if self._hum is None:
            return means.volts
        # hum keeps its phase over the seconds of a drop: the mains is that steady
        return np.asarray(means.volts - self._hum.at(self._time_s(means) - self._hum_from_s))

    def _time_s(self, means: Means) -> FloatArray:
        return np.asarray(means.index / self._digitisation.sample_rate_hz)

    def _columns(self, seconds: float) -> int:
        return max(1, round(seconds * self._samples.rate_hz))


def _pairs(volts: FloatArray) -> list[FloatArray]:
    """Return I and Q of each receiver, shape (2, n) each."""
    return [volts[first : first + 2] for first in range(0, volts.shape[0], 2)]
