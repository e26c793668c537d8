"""The way of the corrections that take each receiver by itself: correct, demodulate, locate."""

from collections.abc import Callable

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.correct import correct
from radargui.correction.phase import unwrap, wrapped_phase
from radargui.model.corrected import CorrectedIQ
from radargui.model.path import PathLengths
from radargui.model.setup import Setup
from radargui.processing.continuity import checked, is_alone, lay_down
from radargui.processing.locate import locate_body
from radargui.processing.measured_motion import MeasuredMotion


def measure_by_receiver(
    conditioned: Conditioned, setup: Setup, method: str, progress: Callable[[float], None]
) -> MeasuredMotion:
    """Return corrected IQ, path lengths and track by the published, the ellipse or no correction.

    Parameters
    ----------
    conditioned
        Signals, motion, noise.
    setup
        Geometry, wavelength, release position.
    method
        published, ellipse or none.
    progress
        Called with the share done, 0 to 1.
    """
    corrected = correct(conditioned, method, lambda done: progress(0.7 * done))
    paths = demodulate(corrected, conditioned, setup.radar.wavelength_m)
    progress(0.8)
    paths, track = locate_body(paths, setup)
    return checked(MeasuredMotion(corrected, paths, track), conditioned, setup.radar.wavelength_m)


def demodulate(corrected: CorrectedIQ, conditioned: Conditioned, wavelength_m: float) -> PathLengths:
    """Return dL_i = phase_i wavelength / (2 pi), 0 in the mean at rest (Rech & Huang 2019, eq. 1).

    Without a rest the first valid sample is 0. Of one or two receivers `checked` does it, piece by piece.

    Parameters
    ----------
    corrected
        Corrected IQ of all receivers, the wiring's sign applied: moving away raises every phase.
    conditioned
        What it was corrected from: rest, rate.
    wavelength_m
        Of the transmitted wave.
    """
    # invalid samples must not lead the count of turns astray
    masked_i = np.where(corrected.valid, corrected.i, np.nan)
    masked_q = np.where(corrected.valid, corrected.q, np.nan)
    phase = unwrap(wrapped_phase(masked_i, masked_q))
    if not is_alone(conditioned):
        # only changes of L are observable: the rest before the motion is their zero (method 1)
        rest = slice(conditioned.segment.rest_first, conditioned.segment.rest_last)
        phase = lay_down(phase, corrected.valid, np.zeros(conditioned.n_samples, dtype=np.intp), rest)
    per_rad = wavelength_m / (2.0 * np.pi)
    return PathLengths(corrected.time_s, phase, phase * per_rad, corrected.u_phase_rad * per_rad, corrected.valid)
