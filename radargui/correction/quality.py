"""Judge the corrected signal of a receiver: figures that a person understands, and one verdict."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, median
from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import Finding, refuse, warn
from radargui.motion.smoothing import savitzky_golay
from radargui.signals.averager import block_means


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a usable and of a rejected receiver, the same for every correction (decision 19). Chosen by hand.

    Attributes
    ----------
    good_noise, max_noise
        Noise of I and of Q where the fringes are counted (a sample, or a bin of the estimates), in amplitudes: 0.22 is
        10 dB; at 0.5 (3 dB) a step of the phase between neighbours is often lost.
    good_circularity, max_circularity
        Root mean square of |z| - 1 beyond what noise makes; the phase is wrong by about as many radians. At a third of
        a radian the count of fringes is not sure any more.
    good_misfit, max_misfit
        Mean squared residual of an estimate in units of its noise: above 2 more than noise is left, above 10 the model
        of a joint estimate does not describe the scene. Of a circle it says nothing else than its circularity, but the
        faster the samples come the more.
    min_valid
        Share of valid samples of a good receiver.
    min_fringes
        Least number of fringes: with fewer, mismatch and motion cannot be told apart.
    max_gain, max_quadrature_deg
        Gain ratio, or its inverse, and quadrature error of the worst mixer: cheap ones are within 1.6 and 35 degrees.
        An estimate beyond this has taken two circles, or a motion, for a front end.
    """

    good_noise: float = 0.2236
    max_noise: float = 0.5
    good_circularity: float = 0.1
    max_circularity: float = 0.35
    good_misfit: float = 2.0
    max_misfit: float = 10.0
    min_valid: float = 0.9
    min_fringes: float = 1.0
    max_gain: float = 2.0
    max_quadrature_deg: float = 42.0


LIMITS = Limits()
WEAK = "signal_low"
"""Code of the finding that a receiver's noise is what makes it no better than usable."""
OFF_CIRCLE = "off_circle"
"""Code of the findings that a receiver's circle is not round."""
PHASE_OVER_ROUNDNESS = 1.3
"""Phase error over what |z| leaves of its circle: that of a moment is as large, and that at rest, from which all phases
count, is added to it (laboratory, generic and physical scenes, decision 44)."""
MIN_TURNS = 8.0
"""Fringes one way that an image rejection needs: with fewer its line is as wide as its distance from the image."""


def circularity(iq: FloatArray, phase_rad: FloatArray | None = None) -> float:
    """Return the root mean square of |z| - 1, or with phases that of |z| over its mean in each fringe, less one.

    Changes of the radius from fringe to fringe are changes of the echo's strength, which do not affect the phase;
    changes within a fringe are mismatch. Less than two fringes count as one.

    Parameters
    ----------
    iq
        Corrected I and Q of the motion, finite, shape (2, n_samples).
    phase_rad
        Their unwrapped phase, shape (n_samples,).
    """
    radius = np.sqrt(iq[0] ** 2 + iq[1] ** 2)
    if phase_rad is not None:
        radius = radius / _usual_radius(radius, phase_rad)
    return float(np.sqrt(np.mean((radius - 1.0) ** 2)))


def _usual_radius(radius: FloatArray, phase_rad: FloatArray) -> FloatArray | float:
    """Return the mean radius of the fringe that each sample lies in, shape (n_samples,); 1 with less than two."""
    turned = np.abs(phase_rad - phase_rad[0]) / (2.0 * np.pi)
    fringe = np.concatenate([[0], np.cumsum(np.diff(np.floor(turned)) != 0)]).astype(np.intp)
    count = np.bincount(fringe)
    if count.size < 2:
        return 1.0
    mean, middle = np.bincount(fringe, weights=radius) / np.maximum(count, 1), np.cumsum(count) - 0.5 * count
    # incomplete fringes at both ends, and short ones at a turn, do not tell their mean
    whole = count >= 0.3 * median(count)
    local = np.interp(np.arange(radius.size) + 0.5, middle[whole], mean[whole])
    return np.asarray(np.maximum(local, 1e-300))


def image_rejection_db(iq: FloatArray, phase_rad: FloatArray) -> float | None:
    """Return how far the image at -f_doppler lies below the line at +f_doppler, 20 log10(|line| / |image|).

    The longest stretch in which the phase turns one way is multiplied by exp(-j phase) and by exp(+j phase), with the
    phase smoothed over two fringes. The mean of the first is the line, that of the second the image, however the
    Doppler frequency changes.

    Parameters
    ----------
    iq
        Corrected I and Q of the motion, shape (2, n_samples).
    phase_rad
        Unwrapped phase of the motion, shape (n_samples,).

    Returns
    -------
    float or None
        dB; None where no stretch holds eight fringes.
    """
    first, last = _longest_one_way(phase_rad)
    turns = abs(phase_rad[last - 1] - phase_rad[first]) / (2.0 * np.pi) if last > first else 0.0
    window = 2 * int((last - first) / max(turns, 1.0)) + 1
    if turns < MIN_TURNS or window < 5 or window > last - first:
        return None
    smoothed = savitzky_golay(phase_rad[first:last], window)
    z = iq[0, first:last] + 1j * iq[1, first:last]
    # the line's own sidelobes would reach over its image
    taper = np.hanning(last - first)
    turned_back, turned_on = (abs((taper * z * np.exp(sign * 1j * smoothed)).sum()) for sign in (-1.0, 1.0))
    line, image = max(turned_back, turned_on), min(turned_back, turned_on)
    return float(20.0 * np.log10(line / max(image, 1e-12 * line)))


def _longest_one_way(phase_rad: FloatArray) -> tuple[int, int]:
    """Return the stretch between turning points over which the phase changes most."""
    coarse, size = _coarse(phase_rad, 400)
    if coarse.size < 8:
        return 0, 0
    direction = np.sign(np.diff(coarse))
    edges = np.concatenate([[0], np.flatnonzero(direction[1:] != direction[:-1]) + 1, [coarse.size - 1]])
    best = int(np.argmax(np.abs(np.diff(coarse[edges]))))
    return int(edges[best]) * size, int(edges[best + 1]) * size


def assess(
    name: str,
    *,
    iq: FloatArray,
    phase_rad: FloatArray,
    valid: BoolArray,
    noise: float,
    counted_noise: float | None = None,
    fraction_clipped: float,
    chi_square: float | None = None,
    rescaled: bool = False,
    **front_end: Any,
) -> ChannelQuality:
    """Return the quality of one receiver in the motion segment, with why it is not good.

    Parameters
    ----------
    name
        Receiver.
    iq
        Corrected I and Q of the motion, shape (2, n_samples).
    phase_rad
        Unwrapped phase of the motion, shape (n_samples,).
    valid
        Shape (n_samples,).
    noise
        White noise of I and of Q in a sample, in amplitudes.
    counted_noise
        The same where the fringes are counted; None: in each sample.
    fraction_clipped
        Share of samples at the end of the range.
    chi_square
        Misfit of a correction that models the samples.
    rescaled
        Whether the correction has scaled each piece by its own extreme; then a changing radius is mismatch, too.
    front_end
        gain_ratio, quadrature_error_deg, u_gain_ratio, u_quadrature_error_deg, where the correction knows them.
    """
    used = valid & np.isfinite(iq).all(axis=0)
    counted = used & np.isfinite(phase_rad)
    turned = None if rescaled else phase_rad[counted]
    roundness = circularity(iq if counted.all() else iq[:, counted], turned) if counted.any() else float("nan")
    whole = bool(np.isfinite(iq).all() and np.isfinite(phase_rad).all())
    known = phase_rad[np.isfinite(phase_rad)]
    quality = ChannelQuality(
        name=name,
        snr_db=float(10.0 * np.log10(0.5 / noise**2)) if noise > 0 else None,
        circularity=roundness if np.isfinite(roundness) else None,
        # over a hole nobody knows how the phase turned
        image_rejection_db=image_rejection_db(iq, phase_rad) if whole else None,
        fringes=_fringes(known),
        fraction_valid=float(valid.mean()) if valid.size else None,
        fraction_clipped=fraction_clipped,
        **front_end,
    )
    finding = judge(quality, noise, noise if counted_noise is None else counted_noise, chi_square)
    return replace(quality, finding=finding)


def judge(quality: ChannelQuality, noise: float, counted_noise: float, chi_square: float | None) -> Finding | None:
    """Return why a receiver is rejected, or usable only; None where it is good. Parameters as in `assess`."""
    roundness = float("nan") if quality.circularity is None else quality.circularity
    # along the radius noise scatters like a mismatch: their squares add
    beyond_noise = float(np.sqrt(max(roundness**2 - noise**2, 0.0))) if np.isfinite(roundness) else float("nan")
    # only models of the samples have one
    misfit = 0.0 if chi_square is None else chi_square
    if counted_noise > LIMITS.max_noise:
        return refuse("noise_too_high", share=counted_noise)
    # what noise explains is not blamed on the circle first
    weak = bool(max(noise, counted_noise) > LIMITS.good_noise)
    # not the other way round: an unknown one is no circle
    if not beyond_noise < LIMITS.max_circularity:
        return refuse(OFF_CIRCLE, share=beyond_noise, weak=weak)
    gain, angle_deg = quality.gain_ratio or 1.0, quality.quadrature_error_deg or 0.0
    if not 1.0 / LIMITS.max_gain < gain < LIMITS.max_gain or not abs(angle_deg) < LIMITS.max_quadrature_deg:
        return refuse("mixer_impossible", gain_ratio=gain, quadrature_error_deg=angle_deg)
    if quality.fringes is not None and quality.fringes < LIMITS.min_fringes:
        return warn("motion_below_fringe")
    if quality.fraction_valid is not None and quality.fraction_valid < LIMITS.min_valid:
        return warn("few_samples_valid", share=quality.fraction_valid)
    if beyond_noise > LIMITS.good_circularity:
        return warn(OFF_CIRCLE, share=beyond_noise, weak=weak)
    if quality.fraction_clipped:
        return warn("some_samples_clipped", share=quality.fraction_clipped)
    if counted_noise > LIMITS.good_noise:
        return warn(WEAK)
    if misfit > LIMITS.good_misfit:
        return warn("residuals_above_noise")
    return None


def is_weak(quality: ChannelQuality) -> bool:
    """Return whether a receiver is hardly heard: by what counts of its noise, or by that of a single sample."""
    if quality.finding is not None and quality.finding.code == WEAK:
        return True
    # amplitude 1, and noise in I as in Q
    return quality.snr_db is not None and 10.0 ** (-quality.snr_db / 10.0) > 2.0 * LIMITS.good_noise**2


def _fringes(phase_rad: FloatArray) -> float:
    """Return the turns of the phase to and fro, noise below a twentieth of a fringe passed over."""
    coarse, _ = _coarse(phase_rad, 2000)
    return float(np.abs(np.diff(coarse)).sum() / (2.0 * np.pi))


def _coarse(phase_rad: FloatArray, count: int) -> tuple[FloatArray, int]:
    """Return about so many means of a phase, and of how many samples: noise, added up, would be hundreds of fringes."""
    # means: noise from sample to sample would add up to turns that were none
    size = max(1, phase_rad.size // count)
    return block_means(phase_rad, size), size
