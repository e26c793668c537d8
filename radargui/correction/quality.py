"""Quality of one receiver's corrected signal."""

from __future__ import annotations

import numpy as np

from radargui.correction.smooth import savitzky_golay
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.quality import ChannelQuality

LEAST_SNR_DB = 10.0
GOOD_CIRCULARITY = 0.1
LEAST_CIRCULARITY = 0.35
LEAST_FRACTION_VALID = 0.9
LEAST_TURNS = 8.0


def circularity(iq: FloatArray) -> float:
    """Return the root mean square of |z| - 1, in amplitudes.

    Parameters
    ----------
    iq
        Corrected I and Q of the motion, shape (2, n_samples).
    """
    return float(np.sqrt(np.mean((np.hypot(iq[0], iq[1]) - 1.0) ** 2)))


def image_rejection_db(iq: FloatArray, phase_rad: FloatArray) -> float | None:
    """Return how far the image at -f_doppler lies below the line at +f_doppler, 20 log10(|line| / |image|).

    The longest stretch in which the phase turns one way is turned back, and on, by its own phase smoothed over two
    fringes: the mean of the one is the line, of the other the image, whatever way the Doppler frequency changes.

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
    if turns < LEAST_TURNS or window < 5 or window > last - first:
        return None
    smoothed = savitzky_golay(phase_rad[first:last], window, 2)
    z = iq[0, first:last] + 1j * iq[1, first:last]
    taper = np.hanning(last - first)
    turned_back, turned_on = (abs((taper * z * np.exp(sign * 1j * smoothed)).sum()) for sign in (-1.0, 1.0))
    line, image = max(turned_back, turned_on), min(turned_back, turned_on)
    return float(20.0 * np.log10(line / max(image, 1e-12 * line)))


def _longest_one_way(phase_rad: FloatArray) -> tuple[int, int]:
    """Return the stretch between turning points over which the phase changes most."""
    size = max(1, phase_rad.size // 400)
    count = phase_rad.size // size
    if count < 8:
        return 0, 0
    coarse = phase_rad[: count * size].reshape(count, size).mean(axis=1)
    direction = np.sign(np.diff(coarse))
    edges = np.concatenate([[0], np.flatnonzero(direction[1:] != direction[:-1]) + 1, [count - 1]])
    best = int(np.argmax(np.abs(np.diff(coarse[edges]))))
    return int(edges[best]) * size, int(edges[best + 1]) * size


def assess(
    name: str,
    *,
    iq: FloatArray,
    phase_rad: FloatArray,
    valid: BoolArray,
    noise: float,
    clipped: BoolArray,
    gain_ratio: float | None,
    quadrature_error_rad: float | None,
) -> ChannelQuality:
    """Return the quality of one receiver in the motion segment, with a verdict and its reason.

    Parameters
    ----------
    name
        Receiver.
    iq
        Corrected I and Q of the motion, shape (2, n_samples).
    phase_rad
        Unwrapped phase of the motion, shape (n_samples,).
    valid, clipped
        Shape (n_samples,).
    noise
        White noise of I and of Q, in amplitudes.
    gain_ratio, quadrature_error_rad
        Hardware constants where the correction knows them.
    """
    round_error = circularity(iq[:, valid]) if valid.any() else float("nan")
    snr_db = float(10.0 * np.log10(0.5 / noise**2)) if noise > 0 else None
    fraction_valid, fraction_clipped = float(valid.mean()), float(clipped.mean())
    verdict, reason = "good", ""
    if snr_db is not None and snr_db < LEAST_SNR_DB:
        verdict, reason = "rejected", f"signal to noise {snr_db:.0f} dB is below {LEAST_SNR_DB:.0f} dB"
    elif not round_error < LEAST_CIRCULARITY:
        verdict, reason = "rejected", f"corrected I and Q leave the circle by {100 * round_error:.0f} %"
    elif fraction_valid < LEAST_FRACTION_VALID:
        verdict, reason = "usable", f"only {100 * fraction_valid:.0f} % of the samples are valid"
    elif round_error > GOOD_CIRCULARITY:
        verdict, reason = "usable", f"corrected I and Q leave the circle by {100 * round_error:.0f} %"
    elif fraction_clipped > 0:
        verdict, reason = "usable", f"{100 * fraction_clipped:.2g} % of the samples are clipped"
    return ChannelQuality(
        name=name,
        snr_db=snr_db,
        circularity=round_error if np.isfinite(round_error) else None,
        image_rejection_db=image_rejection_db(iq, phase_rad),
        fringes=_fringes(phase_rad),
        fraction_valid=fraction_valid,
        fraction_clipped=fraction_clipped,
        gain_ratio=gain_ratio,
        quadrature_error_deg=None if quadrature_error_rad is None else float(np.degrees(quadrature_error_rad)),
        verdict=verdict,
        reason=reason,
    )


def _fringes(phase_rad: FloatArray) -> float:
    """Return the turns of the phase to and fro, noise below a twentieth of a fringe passed over."""
    size = max(1, phase_rad.size // 2000)
    count = max(1, phase_rad.size // size)
    coarse = phase_rad[: count * size].reshape(count, size).mean(axis=1)
    return float(np.abs(np.diff(coarse)).sum() / (2.0 * np.pi))
