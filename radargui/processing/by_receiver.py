"""The way of the corrections of each receiver by itself: its phase, its path lengths, the place of the body."""

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.correct import correct
from radargui.model.arrays import FloatArray
from radargui.model.result import CorrectedIQ, PathLengths
from radargui.model.setup import Setup
from radargui.processing.continuity import checked, is_alone, lay_down
from radargui.processing.measured_motion import MeasuredMotion, Report, locate_body


def measure_by_receiver(conditioned: Conditioned, setup: Setup, method: str, progress: Report) -> MeasuredMotion:
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
    corrected, phase = correct(conditioned, method, lambda done: progress(0.7 * done))
    paths = demodulate(corrected, phase, conditioned, setup.radar.wavelength_m)
    progress(0.8)
    paths, track = locate_body(paths, setup)
    return checked(MeasuredMotion(corrected, paths, track), conditioned, setup.radar.wavelength_m)


def demodulate(
    corrected: CorrectedIQ, phase_rad: FloatArray, conditioned: Conditioned, wavelength_m: float
) -> PathLengths:
    """Return dL_i = phase_i wavelength / (2 pi), 0 in the mean at rest (Rech & Huang 2019, eq. 1).

    Without a rest the first valid sample is 0. Of one or two receivers `checked` does it, piece by piece.

    Parameters
    ----------
    corrected
        Corrected IQ of all receivers, the wiring's sign applied: moving away raises every phase.
    phase_rad
        Unwrapped, shape (n_receivers, n_samples); NaN where not valid.
    conditioned
        What it was corrected from: rest, rate.
    wavelength_m
        Of the transmitted wave.
    """
    if not is_alone(conditioned):
        # only changes of L are observable: the rest before the motion is their zero (method 1)
        rest = slice(conditioned.segment.rest_first, conditioned.segment.rest_last)
        phase_rad = lay_down(phase_rad, corrected.valid, np.zeros(conditioned.n_samples, dtype=np.intp), rest)
    per_rad = wavelength_m / (2.0 * np.pi)
    change_m, u_m = phase_rad * per_rad, corrected.u_phase_rad * per_rad
    return PathLengths(corrected.time_s, phase_rad, change_m, u_m, corrected.valid)
