"""Find the end of the rest, the onset: where the signals leave what the rest before predicts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from radargui.model.arrays import FloatArray, IntArray, median
from radargui.signals.segment import Motion


@dataclass(frozen=True, slots=True)
class OnsetSettings:
    """How the end of the rest is sought; chosen on pendulums and drifting drops (`bench accuracy`).

    Attributes
    ----------
    block_s
        Length of the means that are compared: the noise of a 5 ms mean is what a creeping tracer must exceed.
    window, ahead
        Number of blocks that a parabola is laid through, a line while there are fewer, and of blocks between these and
        the predicted one: a slow start must not be part of its own prediction.
    fewest
        Blocks of rest needed: 50 ms.
    threshold
        Difference from the prediction that ends the rest, if two blocks in turn exceed it: in standard deviations, root
        mean square over the channels.
    max_wander
        Largest standard deviation within a rest, as a share of that of the whole record.
    widths, sigmas
        Numbers of blocks that are averaged, one after another, to find a creeping tracer; and the standard deviations
        by which it must have crept, for single blocks and for longer means.
    crept, moved, swept
        Distances of I and Q from where they began, in radii of their circle: at which a creep is seen, at which the
        tracer has moved (0.3 mm of path), and which no drift reaches.
    even
        Largest share of the way that a tracer may have gone at half of the time. An even drift has gone a half, one
        that grows with the square of time a quarter; a body that rested before it set off gently less.
    short_s, under_way, drift_hz
        A quiet part is no rest if it is shorter than `short_s`, and I and Q move in it by more than `under_way` radii
        (0.05 mm of path) and faster than `drift_hz` radii a second.
    """

    block_s: float = 0.005
    window: int = 60
    ahead: int = 3
    fewest: int = 10
    threshold: float = 6.0
    max_wander: float = 0.02
    widths: tuple[int, ...] = (1, 4, 10)
    sigmas: tuple[float, float] = (6.0, 4.0)
    crept: float = 0.015
    moved: float = 0.06
    swept: float = 0.5
    even: float = 0.15
    short_s: float = 0.25
    under_way: float = 0.01
    drift_hz: float = 0.3


SETTINGS = OnsetSettings()


@dataclass(frozen=True, slots=True)
class RestSettings:
    """Which part of the quiet samples counts as rest. Chosen by hand.

    Attributes
    ----------
    before_onset_s
        Time left out before the onset, because a slow beginning is seen late.
    min_s
        Least rest where there is an onset. As long as the onset is not known, this time is left out before the motion.
    after_motion_s
        Time left out after the motion, because the last small bounces, some 20 ms apart, look like a hum.
    """

    before_onset_s: float = 0.03
    min_s: float = 0.02
    after_motion_s: float = 0.2


REST = RestSettings()
SEEN_ON_S = 0.025
"""After the latest onset that counts: it is one where the next block is away too."""


def rest_before(volts: FloatArray, time_s: FloatArray, motion: Motion) -> tuple[float, float]:
    """Return when the tracer leaves its rest (-inf: it begins in motion), and until when it rests for sure.

    Means over 5 ms do not show every motion. An onset long after the voltages began to shake is not used.
    """
    begin, seen = float(time_s[0]), float(time_s[motion.first])
    if motion.first == 0:
        return float("-inf"), begin
    # every fourth sample tells it as well
    spread = volts[:, ::4].std(axis=1)
    scale = np.maximum(np.sqrt(2.0) * median(spread.reshape(-1, 2), axis=1), 1e-300).repeat(2)
    # what comes after the voltages are seen to shake is no onset
    part = slice(0, int(np.searchsorted(time_s, seen + motion.window_s + SEEN_ON_S)))
    onset = find_onset(time_s[part], volts[:, part] / scale[:, None], spread / scale)
    onset = seen if onset is None or onset > seen + motion.window_s else onset
    if not onset > begin:
        return float("-inf"), begin
    crept = creeps_since(time_s[part], volts[:, part] / scale[:, None], onset)
    if crept is not None:
        rest_end = crept - REST.before_onset_s
        return (crept, rest_end) if rest_end > begin + REST.min_s else (float("-inf"), begin)
    # a slow beginning is seen late: by about as much as the shaking of the voltages is seen after the onset
    late = max(0.0, seen - onset)
    # what looks at rest for as long again before it may be creeping already
    rest_end = max(onset - late - REST.before_onset_s, begin + REST.min_s)
    is_moving = is_under_way(time_s[part], volts[:, part] / scale[:, None], rest_end)
    return (float("-inf"), begin) if is_moving else (onset, rest_end)


def find_onset(time_s: FloatArray, value: FloatArray, spread: FloatArray | None = None) -> float | None:
    """Return the time of the last block that still looks like the rest, None where none departs from it.

    Means over 5 ms are compared with a prediction from the 0.3 s that end 15 ms before them: a parabola, so that
    offsets may drift (a straight line while the rest is shorter). The tracer moves where two blocks in turn differ by
    more than 6 standard deviations in the root mean square over the channels. A rest that is looked at as a whole would
    take the slow beginning of a pendulum for drift.

    A fast motion vanishes in 5 ms means where its Doppler frequency is a multiple of 200 Hz: this function refines the
    end of a rest, it does not tell whether there is one (`find_motion` does).

    Parameters
    ----------
    time_s
        Shape (n_samples,).
    value
        I1, Q1, I2, ... of about equal size, shape (n_channels, n_samples).
    spread
        Standard deviation of each channel in the whole record, where these are its first samples only.

    Returns
    -------
    float or None
        -inf where the record starts in motion (less than 50 ms of rest).
    """
    fewest, (first, count, mean) = SETTINGS.fewest, _means(time_s, value)
    if first.size < 2 * fewest:
        return float("-inf")
    early = np.diff(value[:, : first[2 * fewest - 1]], axis=1)
    # differences of neighbours: a drift adds hardly anything to them
    # 0.95: the median of a difference of two normal numbers, in the deviation of one
    white = median(np.abs(early), axis=1) / 0.95 / np.sqrt(count[0]) + 1e-12
    spread = value.std(axis=1) if spread is None else spread
    size = np.stack([white, np.maximum(white, SETTINGS.max_wander * median(spread))])
    # what differs from a straight line by more than a rest may is none
    basis = _foresight(fewest, 1).basis
    bent = mean[:, :fewest] - (mean[:, :fewest] @ basis) @ basis.T
    if np.sqrt(((bent / size[1][:, None]) ** 2).mean(axis=0)).max() > SETTINGS.threshold:
        return float("-inf")
    away = _departures(mean, size) > SETTINGS.threshold
    # one block alone may be a spike; a body that moves stays away
    lasting = np.flatnonzero(away[:-1] & away[1:])
    return float(time_s[first[fewest + SETTINGS.ahead + lasting[0]]]) if lasting.size else None


def creeps_since(time_s: FloatArray, value: FloatArray, onset_s: float) -> float | None:
    """Return when the tracer set off so gently that predictions followed it; None where it rested until the onset.

    A motor that speeds up by 0.1 m/s^2 turns I and Q along a parabola at first, as a drift does: windows that move with
    it predict it, and at 30 dB a tracer had gone 40 mm before a block differed. Here each 5 ms mean is compared with
    the first 50 ms. Two receivers must have moved. Their distance d grows as (t - t_0)^2: if it reaches some value at
    t_1 and four times that value at t_2, then t_0 = 2 t_1 - t_2.

    Parameters
    ----------
    time_s, value
        As for `find_onset`, in radii of the circles.
    onset_s
        As found there.
    """
    block_s, fewest = SETTINGS.block_s, SETTINGS.fewest
    before = int((time_s < onset_s).sum())
    if before == 0 or int((time_s[before - 1] - time_s[0]) / block_s) < 2 * fewest:
        return None
    first, _, mean = _means(time_s[:before], value[:, :before])
    away = mean - mean[:, :fewest].mean(axis=1, keepdims=True)
    noise = white = float(mean[:, :fewest].std(axis=1).max())
    total = np.cumsum(np.pad(away, ((0, 0), (1, 0))), axis=1)
    # what drowns in 5 ms may stand out of longer means: slides of 1.5 mm before a fall were missed at 22 dB
    for width in SETTINGS.widths:
        if away.shape[1] < 2 * fewest + width:
            break
        wide = (total[:, width:] - total[:, :-width]) / width
        if width > 1:
            # from differences of neighbours in the first half: slow noise does not fall as white noise does
            still = wide[:, : wide.shape[1] // 2 + width]
            apart = median(np.abs(still[:, width:] - still[:, :-width]), axis=1) / 0.95
            noise = max(white / np.sqrt(width), float(apart.max()))
        middle_s = time_s[first[: wide.shape[1]]] + (width - 1) / 2.0 * block_s
        if (crept_s := _crept_since(middle_s, wide, SETTINGS.sigmas[width > 1] * noise)) is not None:
            return max(crept_s, float(time_s[0]))
    return None


def _crept_since(begin_s: FloatArray, away: FloatArray, least: float) -> float | None:
    """Return when blocks (n_channels, n) that begin at some times set off along a parabola; None where none did."""
    fewest = SETTINGS.fewest
    # of two receivers: one alone may have a cable that is touched
    d = np.sort(np.hypot(away[0::2], away[1::2]), axis=0)[-min(2, away.shape[0] // 2)]
    seen = max(SETTINGS.crept, least)
    moved = max(SETTINGS.moved, 4.0 * seen)
    half_way = float(median(d[d.size // 2 - fewest // 2 : d.size // 2 + fewest // 2]))
    if d.max() < moved or (d.max() < SETTINGS.swept and half_way > SETTINGS.even * d.max()):
        return None
    t_2 = float(begin_s[np.argmax(d >= moved)])
    last_still = int(np.flatnonzero(d[: int(np.argmax(d >= moved)) + 1] < seen)[-1])
    return 2.0 * (float(begin_s[last_still]) + SETTINGS.block_s) - t_2


def is_under_way(time_s: FloatArray, value: FloatArray, rest_end_s: float) -> bool:
    """Whether what looks like a short rest at the beginning of a record is the beginning of a motion.

    The last of its 5 ms means has left the first by more than a drift, and by six deviations, in two receivers.

    Parameters
    ----------
    time_s, value
        As for `find_onset`, in radii of the circles.
    rest_end_s
        As found.
    """
    count = int(np.searchsorted(time_s, rest_end_s))
    size = max(1, int(np.searchsorted(time_s, time_s[0] + SETTINGS.block_s)))
    if rest_end_s - time_s[0] > SETTINGS.short_s or count < 2 * size:
        return False
    first, last = value[:, :size].mean(axis=1), value[:, count - size : count].mean(axis=1)
    # of the difference of two means, from differences of neighbours, of which drift is no part
    u = median(np.abs(np.diff(value[:, :count], axis=1)), axis=1) / 0.95 * np.sqrt(2.0 / size)
    far, u_far = np.hypot(*(last - first).reshape(-1, 2).T), np.hypot(*u.reshape(-1, 2).T)
    # one alone may have a cable that is touched
    drift = SETTINGS.under_way + SETTINGS.drift_hz * (rest_end_s - time_s[0])
    return bool((far > np.maximum(drift, SETTINGS.threshold * u_far)).sum() >= min(2, far.size))


def _means(time_s: FloatArray, value: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the first sample and the number of each 5 ms block, shapes (n_blocks,), and means (n_channels, n_blocks).

    Blocks are counted by time, so that lost samples make a block shorter or leave it out.
    """
    label = ((time_s - time_s[0]) / SETTINGS.block_s).astype(np.intp)
    first = np.flatnonzero(np.diff(label, prepend=-1))
    count = np.diff(np.append(first, label.size))
    return first, count, np.add.reduceat(value, first, axis=1) / count


class _Foresight:
    """A polynomial through n blocks in turn: columns, orthonormal, that make it up, and its value some blocks later."""

    def __init__(self, count: int, degree: int) -> None:
        place = (np.arange(count) - count - SETTINGS.ahead) / SETTINGS.window
        powers = np.vander(place, degree + 1, increasing=True)
        self.basis, upper = np.linalg.qr(powers)
        self.ahead: FloatArray = self.basis @ np.linalg.inv(upper)[0]
        self.freedom = float(count - degree - 1)
        self.widening = float(np.sqrt(1.0 + self.ahead @ self.ahead))


class _Growing:
    """Polynomials through the first blocks of a record, each through one block more, as rows padded with zeros."""

    def __init__(self) -> None:
        counts = range(SETTINGS.fewest, SETTINGS.window)
        # a short rest does not determine a curvature
        each = [_foresight(count, 1) for count in counts]
        self.basis, self.ahead = np.zeros((len(each), SETTINGS.window, 2)), np.zeros((len(each), SETTINGS.window))
        for row, ahead, own in zip(self.basis, self.ahead, each, strict=True):
            row[: own.ahead.size], ahead[: own.ahead.size] = own.basis, own.ahead
        self.inside = np.arange(SETTINGS.window) < np.array(counts)[:, None]
        self.freedom, self.widening = (
            np.array([getattr(own, name) for own in each]) for name in ("freedom", "widening")
        )


_foresight, _growing = lru_cache(maxsize=256)(_Foresight), lru_cache(maxsize=4)(_Growing)
"""They depend on nothing that was recorded."""


def _departures(mean: FloatArray, size: FloatArray) -> FloatArray:
    """Return how far each block from the first that can be foretold on lies from that, rms over the channels.

    Parameters
    ----------
    mean
        Shape (n_channels, n_blocks).
    size
        Smallest and largest deviation of a block, shape (2, n_channels).
    """
    n, window, ahead = mean.shape[1], SETTINGS.window, SETTINGS.ahead

    def apart(
        rest: FloatArray, foretold: FloatArray, first: int, freedom: FloatArray | float, widening: FloatArray | float
    ) -> FloatArray:
        """Return it in deviations from what windows foretell of the blocks from `first` on."""
        deviation = np.sqrt((rest**2).sum(axis=2) / freedom)
        deviation = np.clip(deviation, size[0][:, None], size[1][:, None]) * widening
        now = mean[:, first : first + foretold.shape[1]]
        return np.asarray(np.sqrt((((now - foretold) / deviation) ** 2).mean(axis=0)))

    grown, own = _growing(), _foresight(window, 2)
    count = min(window, n - ahead) - SETTINGS.fewest
    begun = np.zeros((mean.shape[0], window))
    begun[:, : min(n, window)] = mean[:, :window]
    basis, inside = grown.basis[:count], grown.inside[:count]
    weights = np.einsum("cb,wbd->cwd", begun, basis)
    rest = np.where(inside, begun[:, None] - np.einsum("cwd,wbd->cwb", weights, basis), 0.0)
    foretold = begun @ grown.ahead[:count].T
    out = [apart(rest, foretold, SETTINGS.fewest + ahead, grown.freedom[:count], grown.widening[:count])]
    if n > window + ahead:
        windows = sliding_window_view(mean, window, axis=1)[:, : n - window - ahead]
        rest = windows - (windows @ own.basis) @ own.basis.T
        out.append(apart(rest, windows @ own.ahead, window + ahead, own.freedom, own.widening))
    return np.concatenate(out)
