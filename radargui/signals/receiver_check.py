"""Check that I and Q are a pair: of one frequency, of similar strength, a quarter of a turn apart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, median
from radargui.model.finding import Finding, refuse
from radargui.signals.doppler import Doppler
from radargui.signals.noise import MIN_SAMPLES, SIXTH_DIFFERENCE_GAIN, sixth_differences
from radargui.signals.whole_turn import turn_around_ellipse


@dataclass(frozen=True, slots=True)
class PairSettings:
    """Limits for I and Q of one receiver.

    Chosen by hand where no figure stands; `bench robust` and `bench real` are the test (decision 20).

    Attributes
    ----------
    min_frames
        Clear frames without which nothing is said.
    min_clear
        Share of clear frames below which nothing is said: single clear frames may come from slow noise and the floor.
    min_bins
        Least Doppler frequency of a frame that counts, in bins of its spectrum.
    min_line
        Least power of a line, as a share of that of a target that moved I and Q as far but turned all the time: an arc
        of a few degrees to and fro has a hundredth.
    gain
        Largest ratio of I to Q, either way: mixers of 24 GHz modules have up to 1.6.
    min_sine
        Of the phase between I and Q: 0.6 is an error of 53 degrees, beyond what a mixer has (35 in cheap ones).
    frames_for_odd, max_odd
        From so many clear frames on, the largest share of them in which gain or phase may be another: where the target
        turns round a frame holds two speeds.
    longest_s
        Longest frames that count: in a slower motion the wave over the floor falls into the same bin.
    odd_gain
        A gain that differs from the typical one by this factor counts as another.
    odd_deg
        A phase that differs from the typical one by so many degrees counts as another.
    max_mixed
        Share of strong frames with more than one frequency.
    max_clipped
        Share of clipped samples in the motion.
    same
        Two channels are the same voltage if they differ by less than this share of their signal.
    sure_deg, doubtful_deg
        Of two receivers with one cable, the one whose I and Q are a quarter of a turn apart within the first has its
        own, where the other misses it by more than the second: more than mixers do.
    min_noise
        Noise below this share of the variance is not compared.
    max_white, min_seen
        White share of what moves I and Q above which it is noise that comes and goes, where fewer frames than the
        second show a line: an echo 10 dB below the noise of a sample still stands 15 dB out of a frame.
    nothing
        Signal beyond the white noise, divided by it, below which a receiver counts as silent, unless its frames show a
        line.
    near
        Mean square difference, as a share of the variance, below which I and Q of two receivers agree.
    shared_noise
        Two receivers are one where they differ by less than this share of their noise.
    """

    min_frames: int = 4
    min_clear: float = 0.4
    min_bins: float = 3.5
    min_line: float = 0.03
    gain: float = 2.5
    min_sine: float = 0.6
    frames_for_odd: int = 8
    max_odd: float = 0.4
    longest_s: float = 0.15
    odd_gain: float = 2.0
    odd_deg: float = 25.0
    max_mixed: float = 0.7
    max_clipped: float = 0.25
    same: float = 0.02
    sure_deg: float = 12.0
    doubtful_deg: float = 30.0
    min_noise: float = 1e-8
    max_white: float = 0.9
    min_seen: float = 0.1
    nothing: float = 0.3
    near: float = 0.1
    shared_noise: float = 0.5


SETTINGS = PairSettings()


def check_receiver(doppler: Doppler, pair_v: FloatArray, noise_v: FloatArray, usable: BoolArray) -> Finding | None:
    """Return why a pair of channels is no receiver of one echo; None where nothing speaks against it.

    Parameters
    ----------
    doppler
        Lines of its frames in the motion.
    pair_v, noise_v, usable
        I and Q in the motion, shapes (2, n), (2,), (2, n).
    """
    # first: a clipped sine has harmonics, which all that follows would take for faults
    clipped = float((~usable).any(axis=0).mean())
    if clipped > SETTINGS.max_clipped:
        return refuse("samples_clipped", share=clipped)
    # less noise: a dead input still has its own
    variance = pair_v.var(axis=1)
    # what moves them beyond their own noise
    spread = np.sqrt(np.maximum(variance - noise_v**2, 0.0))
    unseen = doppler.clear.mean() < SETTINGS.min_seen
    if unseen and (spread < SETTINGS.nothing * noise_v).all():
        return refuse("antenna_off")
    weak, strong = ("I", "Q") if spread[0] < spread[1] else ("Q", "I")
    if spread.min() <= 0.02 * spread.max():
        return refuse("channel_off", weak=weak, strong=strong)
    moved = pair_v - pair_v.mean(axis=1, keepdims=True)
    # either sign: where the wiring inverts Q, it was inverted again
    apart = float(variance.sum()) - 2.0 * abs(float(moved[0] @ moved[1])) / pair_v.shape[1]
    if apart < min(SETTINGS.same**2 * spread.min() ** 2 + 1.2 * float((noise_v**2).sum()), 0.05 * spread.min() ** 2):
        return refuse("signal_on_both")
    white = SETTINGS.max_white * SIXTH_DIFFERENCE_GAIN * pair_v.shape[1] * variance
    if unseen and ((sixth_differences(pair_v) ** 2).sum(axis=1) > white).all():
        return refuse("noise_in_bursts")
    # slower than some bins of the spectrum, a turn round and the bias that turns with it fill the same frame
    clear = doppler.clear & (doppler.frequency_hz >= SETTINGS.min_bins * doppler.resolution_hz)
    # a hand that trembles moves I and Q to and fro along a short arc, together: only whole turns tell a pair. One that
    # turns all the time has this power, with Hann's window
    whole_turns = doppler.size / 3.0 * float(variance.sum() / (noise_v**2).sum())
    clear &= doppler.power > SETTINGS.min_line * whole_turns
    mixed = doppler.mixed
    if int(mixed.sum()) >= SETTINGS.min_frames and mixed.sum() > SETTINGS.max_mixed * (mixed.sum() + clear.sum()):
        return refuse("several_frequencies")
    if int(clear.sum()) < SETTINGS.min_frames or doppler.clear.mean() < SETTINGS.min_clear:
        return None
    fault = _fault_of_lines(doppler, clear, spread)
    if fault is None:
        return None
    # a sphere that bounces low is up and down within one frame: its lines at +f and -f add up to any gain and angle
    turn = turn_around_ellipse(pair_v[:, usable.all(axis=0)], noise_v)
    if turn.is_whole:
        return None
    return refuse("arc_too_short", cause=fault) if turn.is_arc else fault


def _fault_of_lines(doppler: Doppler, clear: BoolArray, spread: FloatArray) -> Finding | None:
    """Return what gain and phase between I and Q in some frames say against a pair; `spread` moves each, (2,)."""
    i, q = np.maximum(np.abs(doppler.i[clear]), 1e-300), np.maximum(np.abs(doppler.q[clear]), 1e-300)
    gain = float(median(q / i))
    if not 1.0 / SETTINGS.gain < gain < SETTINGS.gain:
        if spread.min() > spread.max() / SETTINGS.gain:
            return refuse("pair_of_two_motions")
        weak, strong = ("Q", "I") if gain < 1.0 else ("I", "Q")
        return refuse("channel_dead", weak=weak, strong=strong, share=min(gain, 1 / gain))
    # the sign is the direction of the motion, which turns round at each bounce
    angle = _angles_deg(doppler, clear)
    typical = float(median(angle))
    if np.sin(np.radians(typical)) < SETTINGS.min_sine:
        return refuse("pair_not_in_quadrature", angle_deg=typical)
    odd = (np.abs(np.log(q / i / gain)) > np.log(SETTINGS.odd_gain)) | (np.abs(angle - typical) > SETTINGS.odd_deg)
    short = doppler.size < SETTINGS.longest_s * doppler.sample_rate_hz
    if short and odd.size >= SETTINGS.frames_for_odd and odd.mean() > SETTINGS.max_odd:
        return refuse("pair_without_phase")
    return None


def is_worse_pair(one: Doppler, other: Doppler) -> bool:
    """Whether of two receivers, one of which has a cable of the other, it is the first: its I and Q are no pair."""
    if min(int(one.clear.sum()), int(other.clear.sum())) < SETTINGS.min_frames:
        return False
    of_one, of_other = (abs(90.0 - float(median(_angles_deg(x, x.clear)))) for x in (one, other))
    return of_one > SETTINGS.doubtful_deg and of_other < SETTINGS.sure_deg


def _angles_deg(doppler: Doppler, frames: BoolArray) -> FloatArray:
    """Return the phase between I and Q in some frames, 0 to 180 degrees."""
    return np.abs(np.degrees(np.angle(doppler.q[frames] * doppler.i[frames].conj())))


def same_channels(
    volts: FloatArray, noise_v: FloatArray, rest_v: FloatArray, phase_sign: int = 1
) -> tuple[tuple[int, int], ...]:
    """Return pairs of channels of different receivers that show one and the same voltage: one cable on two inputs.

    Two echoes seldom agree in offset, amplitude and phase at once within a few hundredths; where they do in I and in Q,
    as ideal mixers around a target on the axis do, one cable is known from two by noise that both share (at rest,
    where a multiplexer's delay makes no difference; 60 dB do). Where two conversions share none, nothing is said.

    Parameters
    ----------
    volts
        In the motion, shape (2 n_receivers, n_samples).
    noise_v
        White noise of each channel.
    rest_v
        At rest before it, shape (2 n_receivers, n_at_rest); with too little of it the motion is compared.
    phase_sign
        Of the wiring, applied to both.
    """
    n_receivers = volts.shape[0] // 2
    # a cable on I and on Q of another shows the same where no sign is applied
    sign = np.tile([1.0, float(phase_sign)], n_receivers)
    apart = _mean_squares_apart(volts, sign)
    unlike = apart
    if rest_v.shape[1] > MIN_SAMPLES:
        # differences: a hum is shared by all cables, white noise by one alone
        unlike = 0.5 * _mean_squares_apart(np.diff(rest_v, axis=1), sign)
    noise = np.add.outer(noise_v**2, noise_v**2)
    shown = np.minimum.outer(volts.var(axis=1), volts.var(axis=1))
    alike = (shown > 0.0) & (apart < np.minimum(SETTINGS.same**2 * shown + 2.0 * noise, 0.05 * shown))
    found: list[tuple[int, int]] = []
    for one, other in combinations(range(n_receivers), 2):
        block = np.s_[2 * one : 2 * one + 2, 2 * other : 2 * other + 2]
        same = alike[block]
        if (apart[block] < SETTINGS.near * shown[block] + 2.0 * noise[block]).diagonal().all():
            audible = noise[block] > SETTINGS.min_noise * shown[block]
            same = same & audible & (unlike[block] < SETTINGS.shared_noise * noise[block])
        found.extend((2 * one + int(a), 2 * other + int(b)) for a, b in np.argwhere(same))
    return tuple(found)


def _mean_squares_apart(volts: FloatArray, sign: FloatArray) -> FloatArray:
    """Return the mean square of each channel's difference from each other, signed, by the products of all with all."""
    products = np.outer(sign, sign) * (volts @ volts.T) / volts.shape[1]
    own = np.diagonal(products)
    return np.asarray(np.maximum(own[:, None] + own - 2.0 * products, 0.0))
