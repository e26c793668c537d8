"""The road step by step: remove hum and skew, correct, demodulate, locate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from radargui.correction.correct import correct
from radargui.correction.hum import without_hum
from radargui.correction.skew import remove_skew
from radargui.geometry.antennas import place_antennas
from radargui.model.corrected import CorrectedIQ
from radargui.model.recording import Recording
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.motion.segment import floor_of_noise, held
from radargui.processing.demodulate import demodulate
from radargui.processing.locate import locate
from radargui.processing.road import Road


def step_by_step(
    recording: Recording, segment: Segment, setup: Setup, method: str, tell: Callable[[float], None]
) -> Road:
    """Return corrected IQ, path lengths and track by the published, the ellipse or no correction.

    Parameters
    ----------
    recording
        Without gaps.
    segment
        The motion in it and the rest before.
    setup
        Geometry, phase sign, release position.
    method
        published, ellipse or none.
    tell
        Called with the share done, 0 to 1.
    """
    corrected = corrected_by_steps(recording, segment, method, tell)
    paths = demodulate(corrected, segment, setup.radar.wavelength_m, setup.radar.phase_sign)
    tell(0.8)
    track = locate(paths, place_antennas(setup), np.array(setup.tracer.release_position_m), setup.processing.geometry)
    return Road(corrected, paths, track)


def corrected_by_steps(
    recording: Recording, segment: Segment, method: str, tell: Callable[[float], None]
) -> CorrectedIQ:
    """Return corrected IQ with what the correction found on its way; parameters as of `step_by_step`."""
    volts = recording.volts()
    rate_hz = recording.digitisation.sample_rate_hz
    unusable = recording.clipped() | ~np.isfinite(volts)
    volts = held(volts)
    noise_v = floor_of_noise(volts)
    volts = remove_skew(without_hum(volts, rate_hz, segment, noise_v), rate_hz, recording.digitisation.channel_skew_s)
    tell(0.1)
    time_s = recording.time_s()
    return correct(volts, time_s, rate_hz, segment, noise_v, unusable, method, lambda done: tell(0.1 + 0.6 * done))
