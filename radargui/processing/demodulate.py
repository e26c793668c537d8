"""Path lengths from corrected IQ."""

from __future__ import annotations

import numpy as np

from radargui.correction.phase import unwrap, wrapped_phase
from radargui.model.corrected import CorrectedIQ
from radargui.model.path import PathLengths
from radargui.model.segment import Segment


def demodulate(corrected: CorrectedIQ, segment: Segment, wavelength_m: float, phase_sign: int) -> PathLengths:
    """Return dL_i = phase_sign * phase_i * wavelength / (2 pi), 0 in the mean at rest (Rech & Huang 2019, eq. 1).

    Without a rest the first valid sample is 0.

    Parameters
    ----------
    corrected
        Corrected IQ of all receivers.
    segment
        The motion and the rest before it.
    wavelength_m
        Of the transmitted wave.
    phase_sign
        +1 or -1: moving away must raise every L.
    """
    masked_i = np.where(corrected.valid, corrected.i, np.nan)
    masked_q = np.where(corrected.valid, corrected.q, np.nan)
    phase = phase_sign * unwrap(wrapped_phase(masked_i, masked_q))
    for row, valid in zip(phase, corrected.valid, strict=True):
        rest = row[segment.rest_first : segment.rest_last][valid[segment.rest_first : segment.rest_last]]
        known = np.flatnonzero(valid)
        row -= rest.mean() if rest.size else (row[known[0]] if known.size else 0.0)
    per_rad = wavelength_m / (2.0 * np.pi)
    return PathLengths(corrected.time_s, phase, phase * per_rad, corrected.u_phase_rad * per_rad, corrected.valid)
