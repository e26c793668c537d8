"""Which frames of a spectrum a phase follows."""

import numpy as np

from radargui.conditioning.doppler import Doppler, measure_doppler
from radargui.conditioning.follows import TOGETHER, follows, missed_frames
from radargui.model.arrays import FloatArray

RATE_HZ = 5000.0
TIME_S = np.arange(15000) / RATE_HZ
KNOWN = np.ones(TIME_S.size, dtype=np.bool_)
ON_A_PLATE = 2.0 * np.pi * 3.0 * np.minimum(TIME_S / 0.3, 1.0) ** 2 + 0.9 * np.sin(2.0 * np.pi * 15.0 * TIME_S)
"""A fall of three fringes, then to and fro with a plate that moves it by a millimetre or two: no speed is a line."""


def doppler(phase_rad: FloatArray) -> Doppler:
    noise = 0.01 * np.random.default_rng(1).normal(size=(2, TIME_S.size))
    return measure_doppler(np.stack([np.cos(phase_rad), np.sin(phase_rad)]) + noise, RATE_HZ, np.full(2, 0.01))


def test_a_phase_that_is_up_and_down_within_a_frame_follows_where_its_circle_is_whole() -> None:
    seen = doppler(ON_A_PLATE)
    # an offset makes as much of a phase go to and fro: a circle that is not whole is not believed
    assert not follows(*missed_frames(ON_A_PLATE, KNOWN, seen), TOGETHER)
    assert follows(*missed_frames(ON_A_PLATE, KNOWN, seen, is_whole=True), TOGETHER)


def test_a_phase_that_shows_another_line_does_not_follow_on_whatever_circle() -> None:
    steady = 2.0 * np.pi * 40.0 * TIME_S
    quicker = ON_A_PLATE + 0.9 * (np.sin(2.0 * np.pi * 37.0 * TIME_S) - np.sin(2.0 * np.pi * 15.0 * TIME_S))
    for shown, other in ((steady, ON_A_PLATE), (steady, 0.7 * steady), (ON_A_PLATE, quicker)):
        assert not follows(*missed_frames(other, KNOWN, doppler(shown), is_whole=True), TOGETHER)
