"""Samples to a track while they arrive: causal, a few microseconds a sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.correction.circle_follower import CircleFollower
from radargui.geometry.antennas import place_antennas
from radargui.geometry.bistatic import locate_exact
from radargui.model.arrays import FloatArray, IntArray, RawArray
from radargui.model.digitisation import Digitisation
from radargui.model.setup import Setup
from radargui.motion.trigger import MotionTrigger
from radargui.processing.locate import LEAST_RECEIVERS

LIVE_RATE_HZ = 4000.0
"""Block means at this rate still follow a Doppler of several hundred Hz."""
BEFORE_MOTION_S = 0.03
LONGEST_START_S = 2.0
"""Motion kept while the first 1.5 fringes are not complete."""


@dataclass(frozen=True, slots=True)
class LiveEstimate:
    """What the newest samples say; columns are block means.

    Attributes
    ----------
    index
        Absolute sample index of each column, shape (n,), ascending; samples of the first fringes come late, when the
        correction is known.
    i, q
        Corrected, in amplitudes, shape (n_receivers, n); NaN while the correction is not known.
    change_m
        Change of path length from the rest, shape (n_receivers, n).
    position_m
        Shape (3, n); the release position at rest, NaN while unknown or with fewer than three receivers.
    moving
        Whether the tracer moves now.
    """

    index: IntArray
    i: FloatArray
    q: FloatArray
    change_m: FloatArray
    position_m: FloatArray
    moving: bool


class LiveProcessor:
    """The causal road from raw samples to positions.

    Samples are averaged to about 4 kHz, the multiplexer skew is interpolated away, and each receiver is corrected by a
    circle that follows the signal once 1.5 fringes have passed; before, the sphere is at its release position.

    Parameters
    ----------
    setup
        Geometry and release position.
    digitisation
        How the samples to be pushed were taken.
    """

    def __init__(self, setup: Setup, digitisation: Digitisation) -> None:
        self._setup = setup
        self._digitisation = digitisation
        self._antennas = place_antennas(setup)
        self._release_m = np.array(setup.tracer.release_position_m)
        self._size = max(1, round(digitisation.sample_rate_hz / LIVE_RATE_HZ))
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next sample pushed has index 0 unless `push` is told otherwise."""
        n = self._setup.n_receivers
        self._trigger = MotionTrigger(self._digitisation, self._setup.recording.threshold)
        self._followers = [CircleFollower() for _ in range(n)]
        self._left = np.empty((2 * n, 0))
        self._next_index = 0
        self._before = np.empty((2 * n, 0))
        self._waiting = np.empty((2 * n, 0))
        self._waiting_index = np.empty(0, dtype=np.intp)
        self._phase_rad = np.full(n, np.nan)
        self._phase_zero_rad = np.full(n, np.nan)
        self._position_m = self._release_m.copy()
        self._moved = False

    def push(self, samples: RawArray, first_index: int | None = None) -> LiveEstimate:
        """Take the next samples, shape (n_channels, n); `first_index` tells of a jump (lost samples start anew)."""
        if first_index is not None and first_index != self._next_index + self._left.shape[1]:
            self.reset()
            self._next_index = first_index
        state = self._trigger.push(samples)
        means, index = self._averaged(samples)
        if means.shape[1] == 0:
            return self._estimate(index, means[0::2], means[1::2], means[0::2], moving=state.moving)
        if not state.moving and not self._moved:
            return self._at_rest(means, index)
        self._moved = True
        return self._in_motion(means, index, moving=state.moving)

    def _averaged(self, samples: RawArray) -> tuple[FloatArray, IntArray]:
        """Return block means at the time of channel 0, and the index of each block's middle."""
        volts = np.concatenate([self._left, np.nan_to_num(self._digitisation.volts(samples))], axis=1)
        count = volts.shape[1] // self._size
        self._left = volts[:, count * self._size :]
        means = volts[:, : count * self._size].reshape(volts.shape[0], count, self._size).mean(axis=2)
        index = self._next_index + np.arange(count, dtype=np.intp) * self._size + self._size // 2
        self._next_index += count * self._size
        if count == 0:
            return means, index
        delay = np.arange(volts.shape[0]) * self._digitisation.channel_skew_s * self._digitisation.sample_rate_hz
        earlier = np.concatenate([self._before[:, -1:] if self._before.size else means[:, :1], means[:, :-1]], axis=1)
        self._before = means[:, -1:]
        share = (delay / self._size)[:, None]
        return means * (1.0 - share) + earlier * share, index

    def _at_rest(self, means: FloatArray, index: IntArray) -> LiveEstimate:
        keep = round(BEFORE_MOTION_S * self._digitisation.sample_rate_hz / self._size)
        self._waiting = np.concatenate([self._waiting, means], axis=1)[:, -max(keep, means.shape[1]) :]
        self._waiting_index = np.empty(0, dtype=np.intp)
        nothing = np.full((self._setup.n_receivers, index.size), np.nan)
        position = np.repeat(self._release_m[:, None], index.size, axis=1)
        return LiveEstimate(index, nothing, nothing, np.zeros_like(nothing), position, moving=False)

    def _in_motion(self, means: FloatArray, index: IntArray, *, moving: bool) -> LiveEstimate:
        if not all(follower.started for follower in self._followers):
            return self._starting(means, index, moving=moving)
        corrected = [follower.follow(means[2 * k : 2 * k + 2]) for k, follower in enumerate(self._followers)]
        i, q = np.stack([pair[0] for pair in corrected]), np.stack([pair[1] for pair in corrected])
        return self._estimate(index, i, q, self._changes(i, q), moving=moving)

    def _starting(self, means: FloatArray, index: IntArray, *, moving: bool) -> LiveEstimate:
        """Wait for 1.5 fringes of every receiver; then give all that was waited for at once."""
        longest = round(LONGEST_START_S * self._digitisation.sample_rate_hz / self._size)
        n_rest = self._waiting.shape[1] - self._waiting_index.size
        self._waiting = np.concatenate([self._waiting, means], axis=1)
        self._waiting_index = np.concatenate([self._waiting_index, index])
        if self._waiting_index.size > longest:
            self._waiting, self._waiting_index = self._waiting[:, -longest:], self._waiting_index[-longest:]
            n_rest = 0
        found = [
            follower.started or follower.start(self._waiting[2 * k : 2 * k + 2])
            for k, follower in enumerate(self._followers)
        ]
        if not all(found):
            nothing = np.empty((self._setup.n_receivers, 0))
            return self._estimate(np.empty(0, dtype=np.intp), nothing, nothing, nothing, moving=moving)
        corrected = [follower.correct(self._waiting[2 * k : 2 * k + 2]) for k, follower in enumerate(self._followers)]
        i, q = np.stack([pair[0] for pair in corrected]), np.stack([pair[1] for pair in corrected])
        changes = self._changes(i, q)
        if n_rest > 0:
            zero = changes[:, : max(1, n_rest // 2)].mean(axis=1, keepdims=True)
            changes -= zero
            self._phase_zero_rad += zero[:, 0] * self._rad_per_m
        return self._estimate(self._waiting_index, i[:, n_rest:], q[:, n_rest:], changes[:, n_rest:], moving=moving)

    @property
    def _rad_per_m(self) -> float:
        return self._setup.radar.phase_sign * 2.0 * np.pi / self._setup.radar.wavelength_m

    def _changes(self, i: FloatArray, q: FloatArray) -> FloatArray:
        """Return the change of path length in m, unwrapped on from the samples before."""
        phase = np.arctan2(q, i)
        if np.isnan(self._phase_rad).any():
            self._phase_rad = self._phase_zero_rad = phase[:, 0].copy()
        phase = np.unwrap(np.concatenate([self._phase_rad[:, None], phase], axis=1), axis=1)[:, 1:]
        self._phase_rad = phase[:, -1].copy()
        return np.asarray((phase - self._phase_zero_rad[:, None]) / self._rad_per_m)

    def _estimate(
        self, index: IntArray, i: FloatArray, q: FloatArray, change_m: FloatArray, *, moving: bool
    ) -> LiveEstimate:
        position = np.full((3, index.size), np.nan)
        if self._antennas.n_receivers >= LEAST_RECEIVERS and index.size:
            start = np.repeat(self._position_m[:, None], index.size, axis=1)
            position = locate_exact(change_m, self._antennas, self._release_m, start)
            known = np.isfinite(position).all(axis=0)
            if known.any():
                self._position_m = position[:, np.flatnonzero(known)[-1]]
            else:
                self._position_m = self._release_m.copy()
        return LiveEstimate(index, i, q, change_m, position, moving)
