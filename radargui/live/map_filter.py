"""Correct one receiver live by an extended Kalman filter over a map of its path length.

Recognise motion too slow for the trigger: means of 20 ms and 0.1 s against those of the last half second.
"""

from __future__ import annotations

from collections import deque
from itertools import pairwise

import numpy as np

from radargui.live.rest_statistics import QUIET_PERCENTILE
from radargui.model.arrays import FloatArray, IntArray
from radargui.model.errors import ProcessingError
from radargui.model.front_end import point_of, slopes_of_point
from radargui.signals.ellipse import Ellipse, fit_ellipse

START_FRINGES = 1.5
"""Before the first ellipse (decision 11): in less, offset and amplitude are not told apart. Chosen by hand."""
MIN_ARC_RAD = 2.0 * np.pi * START_FRINGES  # the same as an angle
MIN_START_SAMPLES = 12  # an ellipse has five unknowns: twice as many, and two (chosen by hand)
WORST_START = 0.25
"""Standard deviation of the radius about the first ellipse, in amplitudes, beyond which it is none."""
MAX_GAIN, MAX_ERROR_RAD = 1.7, np.radians(35.0)
"""No mixer is worse (`signals.receiver_check`): an ellipse that says so goes through an arc and what disturbs."""
START_ROUNDS = 3
"""The filter goes so often over the first fringes, each time linearised anew (decision 11). Chosen by hand."""

BINS_PER_FRINGE = 16
"""It is learned once in each bin (decision 11): standstill teaches nothing. Chosen by hand; more cost more time."""
STEP_RAD = 2.0 * np.pi
"""Of phase: what the map learns from at once, for it is linearised at what was known before."""
MAX_BINS = 64
"""Of one update; more are thinned out."""
FORGETTING = 1e-3
"""Share of the prior's variance that comes back with each fringe: drifts are followed."""
NEW_RUN_FORGETTING = 0.05
"""The same from one run to the next."""
MIN_RESIDUAL = 0.005
"""What the map cannot follow (images, converter), in amplitudes, at the least: the signal shows how much it is."""
MISFIT_BINS = 64.0
"""The misfit is the mean of so many bins, four fringes: through one bounce low over a floor that reflects. By hand."""
WORST_MISFIT = 0.5
"""In amplitudes, of one bin at the most: one glitch shall not make the map deaf for four fringes. By hand."""
ROBUST = 4.0
"""Residuals beyond so many standard deviations count less (Huber)."""
SETTLED_FRINGES = 8.0
"""After so many fringes the phase of the rest is not learned any more: the map may have moved on."""

SPAN_M = (-0.30, 0.90)
"""Path lengths, counted from the rest, that the map covers; beyond, its ends hold."""
FINE = 8  # places a knot at which splines are tabled
KNOT_M = 0.04  # path between knots: half of the offsets' length, so that splines can follow it
OFFSET_LENGTH_M = 0.08  # path over which offsets stay alike: over a floor they turn round once in 0.23. Five by hand
AMPLITUDE_LENGTH_M = 0.25  # the same of the amplitude, which changes more slowly
OFFSET_SD = 0.10  # prior standard deviation, in amplitudes
AMPLITUDE_SD = 0.30  # of ln A
HARDWARE_SD = 0.05  # of the gain ratio, and of the quadrature error in rad


class SmoothMap:
    """A state of three splines (offset of I, offset of Q, log amplitude) and two constants (gain ratio, eps in rad).

    Cubic B-splines with knots every 4 cm of path; the prior of their coefficients is a Gaussian process of kernel
    s^2 exp(-d^2 / 2 l^2), l = 8 cm of path for the offsets and 25 cm for the amplitude.

    Attributes
    ----------
    prior
        Covariance of the state before anything is known, shape (n_state, n_state).
    """

    def __init__(self) -> None:
        self._n_pieces = round((SPAN_M[1] - SPAN_M[0]) / KNOT_M)
        self._n = self._n_pieces + 3
        self._fine = self._fine_basis()
        self.prior = self._prior()

    def mean(self) -> FloatArray:
        """Return the state before anything is known: no offset, amplitude 1, a perfect mixer; shape (n_state,)."""
        state = np.zeros(3 * self._n + 2)
        state[-2] = 1.0
        return state

    def parts(self, state: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the coefficients of the three splines, shape (n,) each."""
        n = self._n
        return state[:n], state[n : 2 * n], state[2 * n : 3 * n]

    def table(self, state: FloatArray) -> FloatArray:
        """Return the three splines at the fine knots, shape (n_fine, 3)."""
        return np.asarray(self._fine @ state[: 3 * self._n].reshape(3, self._n).T)

    def values(self, table: FloatArray, length_m: FloatArray) -> FloatArray:
        """Return the three splines of a `table` at path lengths (n_samples,), shape (3, n_samples)."""
        return self._between(table, length_m).T

    def basis(self, length_m: FloatArray) -> FloatArray:
        """Return the basis of uniform cubic B-splines at path lengths (n_samples,), shape (n_samples, n)."""
        return self._between(self._fine, length_m)

    @staticmethod
    def _between(rows: FloatArray, length_m: FloatArray) -> FloatArray:
        # on lines between fine knots: a quarter of the time of cubics, and parts in ten thousand of a spline off
        place = np.minimum(np.maximum((length_m - SPAN_M[0]) * (FINE / KNOT_M), 0.0), rows.shape[0] - 1.001)
        piece = place.astype(np.intp)
        share = (place - piece)[:, None]
        low = rows[piece]
        return np.asarray(low + share * (rows[piece + 1] - low))

    def _fine_basis(self) -> FloatArray:
        """Return the basis at `FINE` places a knot, shape (n_fine, n)."""
        place = np.minimum(np.arange(FINE * self._n_pieces + 1) / FINE, self._n_pieces - 1e-9)
        piece = place.astype(np.intp)
        t = place - piece
        left = 1.0 - t
        out, row = np.zeros((place.size, self._n)), np.arange(place.size)
        out[row, piece] = left**3 / 6.0
        out[row, piece + 1] = (3.0 * t**3 - 6.0 * t**2 + 4.0) / 6.0
        out[row, piece + 2] = (3.0 * left**3 - 6.0 * left**2 + 4.0) / 6.0
        out[row, piece + 3] = t**3 / 6.0
        return out

    def _prior(self) -> FloatArray:
        n = self._n
        place = KNOT_M * np.arange(n)
        away = (place[:, None] - place) ** 2
        out = np.zeros((3 * n + 2, 3 * n + 2))
        out[:n, :n] = out[n : 2 * n, n : 2 * n] = OFFSET_SD**2 * np.exp(-0.5 * away / OFFSET_LENGTH_M**2)
        out[2 * n : 3 * n, 2 * n : 3 * n] = AMPLITUDE_SD**2 * np.exp(-0.5 * away / AMPLITUDE_LENGTH_M**2)
        out[-2, -2] = out[-1, -1] = HARDWARE_SD**2
        return out


class MapFilter:
    """Causal correction: hardware constants, and offset and amplitude that vary smoothly with the path length.

    I and Q in volts, less the centre and over the amplitude of the first fringes, are

        I = b_I(L) + A(L) cos(phase),  Q = b_Q(L) + g A(L) sin(phase + eps),

    with b_I, b_Q and log A smooth functions of the change of path length L. What is observed is that the corrected
    signal lies on the unit circle, r = |z| / A - 1 = 0 (its mean is sigma^2 / 2 under noise), once in each sixteenth of
    a fringe, so that a tracer at rest changes nothing. Because the coordinate is the path length, a fringe that was
    learned on the way down is known on the way up, and the map of one run serves the next run of a session.

    Parameters
    ----------
    rad_per_m
        Phase over path length.

    Attributes
    ----------
    started
        Whether the constants are known.
    """

    def __init__(self, rad_per_m: float) -> None:
        self._rad_per_m = rad_per_m
        self._map = SmoothMap()
        self._mean = self._map.mean()
        self._state = self._mean.copy()
        # of which state the table is
        self._tabled: FloatArray | None = None
        self._table = np.empty((0, 3))
        self._covariance = self._map.prior.copy()
        self._centre_v = np.zeros(2)
        self._scale_v = 1.0
        self._rest_v: FloatArray | None = None
        self._noise_v: float | None = None
        self._zero_rad: float | None = None
        self._phase_rad: float | None = None
        self._binned_rad: float | None = None
        self._fringes = 0.0
        self._misfit_square = 0.0
        self.started = False

    @property
    def gain_ratio(self) -> float:
        """Amplitude of Q over amplitude of I."""
        return float(self._state[-2])

    @property
    def quadrature_error_rad(self) -> float:
        """Departure of Q from 90 degrees after I."""
        return float(self._state[-1])

    @property
    def rest_v(self) -> FloatArray:
        """Voltages of I and Q at the last rest, shape (2,); NaN where none is known."""
        return np.full(2, np.nan) if self._rest_v is None else self._rest_v

    @property
    def misfit(self) -> float:
        """Root mean square distance of the last fringes from the circle that the map predicted, in amplitudes."""
        return float(np.sqrt(self._misfit_square))

    def rest(self, pair_v: FloatArray | None, noise_v: float | None) -> None:
        """Begin a new run: the tracer rests, and L is counted from here.

        Parameters
        ----------
        pair_v
            Mean voltages of I and Q at rest, shape (2,); None: the first sample of the motion is the rest.
        noise_v
            Standard deviation of one channel at rest; None: not known.
        """
        self._rest_v, self._noise_v = pair_v, noise_v
        self._zero_rad = self._phase_rad = self._binned_rad = None
        self._fringes = 0.0
        if self.started:
            # the mixer is the same, the sphere and its release are not
            self._covariance += NEW_RUN_FORGETTING * self._map.prior

    def start(self, pair_v: FloatArray) -> bool:
        """Try to begin with the motion so far; True once the constants are found.

        The model is first linearised at an ellipse through 1.5 fringes or more. The filter then goes over them again
        from its prior, linearised anew each time.

        Parameters
        ----------
        pair_v
            Volts, shape (2, n_samples).
        """
        if self.started:
            return True
        ellipse = _first_ellipse(pair_v)
        if ellipse is None:
            return False
        self._scale_v = ellipse.amplitude_v
        self._centre_v = np.array([ellipse.i0_v, ellipse.q0_v])
        self._mean[-2:] = ellipse.gain_ratio, ellipse.quadrature_error_rad
        self._state = self._mean.copy()
        self.started = True
        for _ in range(START_ROUNDS):
            self._phase_rad = self._binned_rad = None
            self._covariance = self._map.prior.copy()
            phase, _ = self._demodulated(pair_v)
            self._learn(pair_v, phase, self._mean)
        self._phase_rad = None
        return True

    def follow(self, pair_v: FloatArray, *, learn: bool = True) -> tuple[FloatArray, FloatArray]:
        """Learn from the next samples and correct them.

        Parameters
        ----------
        pair_v
            Volts, shape (2, n_samples), at least one sample.
        learn
            False for samples that `start` has learned from.

        Returns
        -------
        tuple
            Corrected I and Q in amplitudes, shape (2, n_samples), and the change of path length from the rest in m,
            shape (n_samples,).
        """
        phase, _ = self._demodulated(pair_v)
        travel = np.abs(phase - np.concatenate([phase[:1], phase[:-1]])).cumsum()
        if not learn or travel[-1] <= STEP_RAD:
            return self._step(pair_v, phase, learn=learn)
        # of five fringes that a fast tracer passes in a block the last would be read by a map that the first have
        # shown to be wrong, and turns are lost
        cuts = np.searchsorted(travel, np.arange(STEP_RAD, travel[-1], STEP_RAD)).tolist()
        edges = sorted({0, *cuts, travel.size})
        parts = []
        for first, last in pairwise(edges):
            seen, pair = phase[first:last], pair_v[:, first:last]
            parts.append(self._step(pair, self._demodulated(pair, seen)[0] if first else seen, learn=True))
        return np.concatenate([z for z, _ in parts], axis=1), np.concatenate([change for _, change in parts])

    def _step(self, pair_v: FloatArray, phase: FloatArray, *, learn: bool) -> tuple[FloatArray, FloatArray]:
        """Do what `follow` does over a fringe or less; `phase` is that of a first look."""
        # forgotten by the way, not by the time: at rest nothing is learned
        fringes = float(np.abs(phase[1:] - phase[:-1]).sum()) / (2.0 * np.pi)
        if learn:
            # the prior comes back whole at the most: more would be less than nothing known
            self._covariance += min(FORGETTING * fringes, 1.0) * self._map.prior
            self._learn(pair_v, phase, self._state)
        phase, corrected = self._demodulated(pair_v, phase)
        self._phase_rad = float(phase[-1])
        self._fringes += fringes
        if self._fringes > SETTLED_FRINGES and self._zero_rad is None:
            self._zero_rad = self._zero()
        return corrected, phase / self._rad_per_m

    def at_rest(self, pair_v: FloatArray) -> FloatArray:
        """Return corrected I and Q of samples at rest, shape (2, n_samples); NaN before the constants are known."""
        if not self.started:
            return np.full(pair_v.shape, np.nan)
        return self._apply(pair_v, np.zeros(pair_v.shape[1]))

    def _zero(self) -> float:
        """Return the phase of the rest under the present map."""
        if self._zero_rad is not None:
            return self._zero_rad
        if self._rest_v is None:
            return 0.0
        corrected = self._apply(self._rest_v[:, None], np.zeros(1))
        return float(np.arctan2(corrected[1, 0], corrected[0, 0]))

    def _demodulated(self, pair_v: FloatArray, seen_rad: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the phase counted from the rest, unwrapped on from the samples before, and corrected I and Q.

        `seen_rad` is the phase of a look before.
        """
        if self._rest_v is None:
            self._rest_v = pair_v[:, 0].copy()
        zero = self._zero()
        before = self._phase_rad or 0.0
        phase = np.full(pair_v.shape[1], before) if seen_rad is None else seen_rad
        # twice: the map is asked where the samples are, and that is known well enough only after a first look
        for _ in range(2 if seen_rad is None else 1):
            corrected = self._apply(pair_v, phase / self._rad_per_m)
            turned = np.arctan2(corrected[1], corrected[0]) - zero
            turned[1:] -= turned[:-1].copy()
            turned[0] -= before
            # as numpy's unwrap does, in a third of its time: a block is short
            phase = before + np.cumsum(turned - 2.0 * np.pi * np.rint(turned / (2.0 * np.pi)))
        return phase, corrected

    def _apply(self, pair_v: FloatArray, length_m: FloatArray) -> FloatArray:
        """Return corrected I and Q in amplitudes at path lengths, shape (2, n_samples)."""
        if self._state is not self._tabled:
            self._tabled, self._table = self._state, self._map.table(self._state)
        offset_i, offset_q, log_amplitude = self._map.values(self._table, length_m)
        gain, eps = self._state[-2:]
        x = (pair_v[0] - self._centre_v[0]) / self._scale_v - offset_i
        y = (pair_v[1] - self._centre_v[1]) / self._scale_v - offset_q
        return np.asarray(point_of(x, y, gain, eps) * np.exp(-log_amplitude))

    def _learn(self, pair_v: FloatArray, phase_rad: FloatArray, mean: FloatArray) -> None:
        """Update from `mean`, which the covariance belongs to, with the model linearised at the present state."""
        chosen = self._bins(phase_rad)
        if chosen.size == 0:
            return
        length_m = phase_rad[chosen] / self._rad_per_m
        corrected, basis = self._apply(pair_v[:, chosen], length_m), self._map.basis(length_m)
        slope, radius = self._slope(corrected, basis)
        # the radius is measured: noise makes it longer by sigma^2 / 2 in the mean
        noise = 0.0 if self._noise_v is None else (self._noise_v / self._scale_v) ** 2
        innovation = 1.0 + 0.5 * noise - radius + slope @ (self._state - mean)
        # floors and walls mirror the sphere: to a map that believed 0.005 in a room where the circle is 0.1 off, each
        # bin was a proof, and in 11 of 24 drops of the laboratory it went where turns are lost
        variance = noise + MIN_RESIDUAL**2 + self._misfit_square
        spread = slope @ self._covariance
        expected = np.einsum("ij,ij->i", spread, slope) + variance
        excess = np.abs(innovation) / (ROBUST * np.sqrt(expected))
        # what is far off counts as if its noise were as large: it pulls, and does not tear
        total = spread @ slope.T + np.diag(variance * np.maximum(excess, 1.0) ** 2)
        # before the update: after it the map has bent itself to these bins
        left = float(np.mean(np.minimum(innovation**2, WORST_MISFIT**2))) - noise
        self._misfit_square += min(1.0, chosen.size / MISFIT_BINS) * (max(left, 0.0) - self._misfit_square)
        # solved in the bins of this update, which are fewer than the coefficients
        gain = np.linalg.solve(total, spread).T
        self._state = mean + gain @ innovation
        covariance = self._covariance - gain @ spread
        # rounding makes it lose its symmetry over thousands of updates, and then its sign
        self._covariance = 0.5 * (covariance + covariance.T)

    def _bins(self, phase_rad: FloatArray) -> IntArray:
        """Return one sample for each bin of phase passed."""
        before = phase_rad[0] if self._binned_rad is None else self._binned_rad
        travel = np.cumsum(np.abs(np.diff(np.concatenate([[before], phase_rad]))))
        number = np.floor(travel * (BINS_PER_FRINGE / (2.0 * np.pi)))
        chosen = np.flatnonzero(np.diff(np.concatenate([[0.0], number])) > 0)
        if chosen.size:
            self._binned_rad = float(phase_rad[chosen[-1]])
        elif self._binned_rad is None:
            self._binned_rad = float(before)
        return np.asarray(chosen[:: max(1, -(-chosen.size // MAX_BINS))], dtype=np.intp)

    def _slope(self, z: FloatArray, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dr/dstate, shape (n_bins, n_state), and |z| / A."""
        gain, eps = self._state[-2:]
        radius = np.maximum(np.hypot(z[0], z[1]), 1e-6)
        cosine, sine = z[0] / radius, z[1] / radius
        scale = np.exp(-(basis @ self._map.parts(self._state)[2]))
        y_by_i, y_by_q, y_by_log_gain, y_by_eps = slopes_of_point(z[0], z[1], float(gain), float(eps))
        by_offset_i, by_offset_q = scale * (sine * y_by_i - cosine), scale * sine * y_by_q
        by_gain, by_eps = sine * y_by_log_gain / gain, sine * y_by_eps
        columns = [basis * by_offset_i[:, None], basis * by_offset_q[:, None], -basis * radius[:, None]]
        return np.concatenate([*columns, by_gain[:, None], by_eps[:, None]], axis=1), radius


def _first_ellipse(pair_v: FloatArray) -> Ellipse | None:
    """Return the ellipse through the first fringes; None while they are not enough."""
    if pair_v.shape[1] < MIN_START_SAMPLES:
        return None
    try:
        ellipse = fit_ellipse(pair_v)
    except ProcessingError:
        return None
    if abs(np.log(ellipse.gain_ratio)) > np.log(MAX_GAIN) or abs(ellipse.quadrature_error_rad) > MAX_ERROR_RAD:
        return None
    x, y = ellipse.apply(pair_v)
    far = np.ptp(np.unwrap(np.arctan2(y, x))) >= MIN_ARC_RAD
    return ellipse if far and float(np.std(np.hypot(x, y))) <= WORST_START else None


BLOCK_S = 0.02
"""Of a mean: a hand, up to 30 Hz of Doppler, is in it, and no hum of 50 Hz."""
TOGETHER = 5
"""Means averaged: a fifth of the noise, and no hum of 60 Hz either."""
WINDOW_S = 0.4
"""In it a hand of 2 cm/s goes half a fringe; what is slower by far is a drift of the electronics. By hand."""
CONFIRM_S = 0.08
"""A drop is fast by then: the trigger tells better when it began. By hand."""
MEMORY_S = 30.0
"""The quiet level is that of so long; chosen by hand."""
EVERY = 16
"""Levels between two looks at all of them."""
MIN_NOISE = 0.01
"""Of the loudest channel's variance: an input that is shorted shows one code, and another once an hour. By hand."""
MIN_SIGMAS = 2.0
"""Times the noise of one sample that a motion changes the means by, at the least (root mean square): an echo of 20 dB
has ten times that noise, and what shakes or drifts by less is no place. By hand."""
MIN_RATE_HZ = 4e4
"""One sample's noise at this rate at the most: a faster device has louder samples, and echoes as before."""
LONGEST_S = 20.0
"""What goes on for longer is the new quiet, a lamp or a fan. By hand."""
LATE_S = BLOCK_S * TOGETHER + WINDOW_S + CONFIRM_S
"""A motion that is told now began so long ago at the most."""


class SlowMotion:
    """Causal detector of motion that the trigger of a drop does not see (below 0.3 m/s with 24 dB at 2 kS/s).

    Activity is the variance of means within 0.4 s, in units of one sample's noise, mean over channels; motion starts
    where that of the short or of the long means exceeds `threshold` squared times its quiet level, which is no less
    than what white noise makes, and ends below half of the threshold.

    Parameters
    ----------
    rate_hz
        Of the samples to be pushed, which are means themselves.
    sample_rate_hz
        Of the device.
    threshold
        How many times harder than in quiet the voltages must change.

    Attributes
    ----------
    moving
        What it said last.
    has_rested
        Whether it was quiet at any time since the first samples.
    """

    def __init__(self, rate_hz: float, sample_rate_hz: float, threshold: float) -> None:
        self._size = max(1, round(BLOCK_S * rate_hz))
        block_s = self._size / rate_hz
        self._samples = block_s * min(sample_rate_hz, MIN_RATE_HZ)
        self._white = 1.0 / (self._samples * np.array([1.0, TOGETHER]))
        self._threshold = threshold
        self._window = max(4, round(WINDOW_S / block_s))
        self._confirm, self._longest = (max(1, round(span / block_s)) for span in (CONFIRM_S, LONGEST_S))
        self._levels: deque[FloatArray] = deque(maxlen=max(8, round(MEMORY_S / block_s)))
        self._quiet, self._n_judged = self._white, 0
        self.has_rested = False
        self.clear()

    def clear(self) -> None:
        """Begin anew, at rest, because samples are missing or belong to another rest."""
        self._left: FloatArray | None = None
        self._means: deque[FloatArray] = deque(maxlen=self._window + TOGETHER - 1)
        self._noises: deque[FloatArray] = deque(maxlen=self._window)
        self._above = 0
        self.moving = False

    def push(self, volts: FloatArray) -> bool:
        """Take the next samples, shape (n_channels, n); return whether something moves after them."""
        whole = volts if self._left is None else np.concatenate([self._left, volts], axis=1)
        count = whole.shape[1] // self._size
        self._left = whole[:, count * self._size :]
        if count == 0:
            return self.moving
        blocks = whole[:, : count * self._size].reshape(whole.shape[0], count, self._size)
        # third differences: what moves slowly is not in them; 20 = 1 + 9 + 9 + 1
        third = blocks[..., 3:] - blocks[..., :-3] - 3.0 * (blocks[..., 2:-1] - blocks[..., 1:-2])
        noises = np.einsum("cbs,cbs->bc", third, third) / (20.0 * max(1, third.shape[2]) * self._size)
        for noise, mean in zip(noises, blocks.mean(axis=2).T, strict=True):
            self._noises.append(noise)
            self._means.append(mean)
            if len(self._means) == self._means.maxlen:
                self._judge(self._activity())
        return self.moving

    def _activity(self) -> FloatArray:
        """Return the variances of short and of long means, shape (2,)."""
        noise = np.mean(self._noises, axis=0)
        largest = float(noise.max())
        if not np.isfinite(largest) or largest <= 0.0:
            return np.zeros(2)
        means = np.array(self._means)
        total = np.cumsum(np.concatenate([np.zeros((1, means.shape[1])), means]), axis=0)
        long = (total[TOGETHER:] - total[:-TOGETHER]) / TOGETHER
        variance = np.stack([means[-self._window :].var(axis=0), long.var(axis=0)])
        return np.asarray((variance / np.maximum(noise, MIN_NOISE * largest)).mean(axis=1) / self._samples)

    def _judge(self, level: FloatArray) -> None:
        least = np.maximum(self._threshold**2 * self._quiet, MIN_SIGMAS**2)
        above = level > (0.25 * least if self.moving else least)
        # a hum of 60 Hz is in the short means: before any quiet nobody knows how much
        self._above = self._above + 1 if above[0 if self.has_rested else 1 :].any() else 0
        if self._above > self._longest:
            self._levels.clear()
            self._above = self._n_judged = 0
        if self._above == 0:
            self.has_rested = True
            self._levels.append(level)
            # now and then: a sort of half a minute is most of what waiting costs
            if self._n_judged % EVERY == 0:
                self._quiet = np.maximum(self._white, np.percentile(self._levels, QUIET_PERCENTILE, axis=0))
            self._n_judged += 1
        # what moves as the first samples come is the first quiet, until there is a better one
        self.moving = self._above > 0 if self.moving else self._above >= self._confirm
