"""Whether I and Q lie around one ellipse, where spectra of what goes to and fro do not tell a pair."""

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.scene import make_record
from support.words import words

from radargui.model.arrays import FloatArray
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.doppler import measure_doppler
from radargui.signals.receiver_check import check_receiver
from radargui.signals.whole_turn import turn_around_ellipse

RATE_HZ = 5000.0
TIME_S = np.arange(10000) / RATE_HZ
NOISE_V = np.full(2, 0.01)
BOUNCING = 2.0 * np.pi * 3.0 * np.abs(np.sin(2.0 * np.pi * 3.1 * TIME_S))
"""To and fro by three turns, six times a second."""
DRIFTING = 2.0 * np.pi * 2.0 * TIME_S


def pair(of_i: FloatArray, of_q: FloatArray, gain: float = 1.0) -> FloatArray:
    noise = 0.01 * np.random.default_rng(2).normal(size=(2, of_i.size))
    return np.stack([0.3 + np.cos(of_i), gain * np.sin(of_q) - 0.2]) + noise


def found(pair_v: FloatArray) -> str:
    doppler = measure_doppler(pair_v, RATE_HZ, NOISE_V)
    return words(check_receiver(doppler, pair_v, NOISE_V, np.ones(pair_v.shape, dtype=np.bool_)))


def test_a_pair_goes_all_around_one_ellipse() -> None:
    turn = turn_around_ellipse(pair(BOUNCING, BOUNCING + 0.3, 1.5), NOISE_V)
    assert turn.is_whole
    assert not turn.is_arc


@pytest.mark.parametrize(
    "pair_v",
    [
        pytest.param(pair(BOUNCING, BOUNCING + np.radians(50.0)), id="40 degrees apart"),
        pytest.param(pair(BOUNCING, BOUNCING + DRIFTING), id="different motions"),
        pytest.param(pair(BOUNCING, BOUNCING, 3.0), id="three times as strong"),
        pytest.param(np.sign(pair(BOUNCING, BOUNCING)), id="corners alone"),
        pytest.param(np.random.default_rng(4).normal(size=(2, 10000)), id="no signal"),
    ],
)
def test_what_is_no_pair_goes_around_none(pair_v: FloatArray) -> None:
    assert not turn_around_ellipse(pair_v, NOISE_V).is_whole


def test_an_arc_tells_nothing() -> None:
    turn = turn_around_ellipse(pair(0.2 * BOUNCING, 0.2 * BOUNCING), NOISE_V)
    assert turn.is_arc
    assert not turn.is_whole


@pytest.mark.parametrize(
    ("motion", "seed", "held"),
    [
        # 4 cm on a plate that stands still; the same that moves by 3 mm; small hops after a fall; 10 cm at 2 kHz
        ("shaken", 941005, {"mode": "dropped", "shake_g": 0.0}),
        ("shaken", 941005, {"mode": "dropped", "shake_hz": 10.0}),
        pytest.param("shaken", 931107, {}, marks=pytest.mark.slow),
        ("drop", 4105008, {"height_m": 0.1}),
    ],
)
def test_a_sphere_that_is_up_and_down_within_one_frame_is_no_fault_of_its_receivers(
    motion: str, seed: int, held: dict[str, object]
) -> None:
    record = make_record(draw(seed, "exact", motion=motion, **held))
    conditioned = condition(record.recording, record.scene.setup)
    assert isinstance(conditioned, Conditioned)
    assert conditioned.faults == (None, None, None)


def test_channels_that_do_not_belong_together_are_still_told_where_a_sphere_bounces_low() -> None:
    record = make_record(draw(941005, "exact", motion="shaken", mode="dropped", shake_g=0.0))
    conditioned = condition(record.recording, record.scene.setup)
    assert isinstance(conditioned, Conditioned)
    moving = slice(conditioned.segment.first, conditioned.segment.last)
    volts, noise_v = conditioned.volts[:, moving], conditioned.noise_v
    one_signal = np.stack([volts[0], 1.2 * volts[0] + 0.3 * volts[1]])
    later = np.stack([volts[0], np.roll(volts[1], volts.shape[1] // 3)])
    for wrong in (one_signal, later):
        doppler = measure_doppler(wrong, conditioned.sample_rate_hz, noise_v[:2])
        assert check_receiver(doppler, wrong, noise_v[:2], np.ones(wrong.shape, dtype=np.bool_))


@pytest.mark.slow
def test_a_motion_of_less_than_a_fringe_is_said_to_be_too_short_to_tell() -> None:
    # hops of a millimetre on a plate
    record = make_record(draw(931101, "exact", motion="shaken"))
    conditioned = condition(record.recording, record.scene.setup)
    assert isinstance(conditioned, Conditioned)
    assert all(fault is not None and fault.code == "arc_too_short" for fault in conditioned.faults)
