"""Quality of each receiver in figures a person understands, and the verdict."""

from __future__ import annotations

import numpy as np

from radargui.correction.hardware import HardwareConstants
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.quality import ChannelQuality

_FEWEST_FRINGES, _LOWEST_SNR_DB = 1.0, 10.0
_HIGHEST_MISFIT, WORST_MISFIT = 2.0, 10.0
_WORST_CIRCULARITY = 0.15


def judge_channels(
    amplitude: FloatArray,
    sigma: FloatArray,
    i: FloatArray,
    q: FloatArray,
    valid: BoolArray,
    change_m: FloatArray,
    wavelength_m: float,
    moving: BoolArray,
    clipped: FloatArray,
    chi_square: FloatArray,
    constants: tuple[HardwareConstants, ...],
) -> tuple[ChannelQuality, ...]:
    """Return the quality of each receiver.

    Parameters
    ----------
    amplitude, sigma
        Typical amplitude and noise of one channel in the same unit, shape (n_receivers,).
    i, q, valid, change_m
        As in MotionEstimate.
    wavelength_m
        Of the radar.
    moving
        Samples of the motion, shape (n_samples,).
    clipped
        Share of clipped samples of each receiver.
    chi_square, constants
        As in MotionEstimate.
    """
    out = []
    for n, own in enumerate(constants):
        use = moving & valid[n] & np.isfinite(i[n])
        radius = np.hypot(i[n, use], q[n, use])
        snr = float(10.0 * np.log10(amplitude[n] ** 2 / (2.0 * sigma[n] ** 2)))
        travelled = np.abs(np.diff(change_m[n, moving][np.isfinite(change_m[n, moving])])).sum()
        fringes = float(travelled / wavelength_m)
        circularity = float(np.sqrt(((radius - 1.0) ** 2).mean())) if use.any() else float("nan")
        verdict, reason = _verdict(snr, fringes, float(chi_square[n]), circularity)
        out.append(
            ChannelQuality(
                str(n + 1),
                snr,
                circularity if np.isfinite(circularity) else None,
                None,
                fringes,
                float(valid[n, moving].mean()) if moving.any() else None,
                float(clipped[n]),
                own.gain_ratio,
                own.quadrature_error_deg,
                verdict,
                reason,
                own.u_gain_ratio,
                own.u_quadrature_error_deg,
            )
        )
    return tuple(out)


def _verdict(snr_db: float, fringes: float, chi_square: float, circularity: float) -> tuple[str, str]:
    if chi_square > WORST_MISFIT and not circularity < _WORST_CIRCULARITY:
        return "rejected", "the model does not describe the signal (cycles lost, or more than one thing moves)"
    if fringes < _FEWEST_FRINGES:
        return "usable", "less than one fringe: the mismatch cannot be told from the motion"
    if snr_db < _LOWEST_SNR_DB:
        return "usable", "low signal-to-noise ratio"
    if chi_square > _HIGHEST_MISFIT:
        return "usable", "residuals above the noise: uncertainties are widened"
    return "good", ""
