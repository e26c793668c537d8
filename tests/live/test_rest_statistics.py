"""Hum, noise and echo at rest: none of them hides a fall from the trigger, and none of them is one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.drops import Drop

from radargui.live.trigger import MotionTrigger, TriggerState
from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation

RATE = 20000.0
SHARES = np.array([[1.0], [0.8], [0.6], [0.9]])
"""Of the hum, in each channel."""
Hum = Callable[[FloatArray], FloatArray]


def sine(amplitude: float = 0.3, frequency_hz: float = 50.0, phase: FloatArray | float = 0.0) -> Hum:
    return lambda time_s: amplitude * np.sin(2.0 * np.pi * frequency_hz * time_s + phase)


def volts(
    time_s: FloatArray, path_m: FloatArray | float = 0.0, hum: Hum | None = None, noise: float = 0.007
) -> FloatArray:
    phase = 2.0 * np.pi * np.broadcast_to(path_m, time_s.shape) / 0.03
    z = np.stack([np.cos(phase), np.sin(phase), np.cos(phase + 1.0), np.sin(phase + 1.0)])
    return np.asarray(z + SHARES * (hum or sine(0.0))(time_s) + np.random.default_rng(0).normal(0.0, noise, z.shape))


def watched(samples: FloatArray, block: int = 200) -> tuple[MotionTrigger, list[TriggerState]]:
    trigger = MotionTrigger(Digitisation(("I1", "Q1", "I2", "Q2"), RATE), threshold=8.0)
    return trigger, [trigger.push(samples[:, begin : begin + block]) for begin in range(0, samples.shape[1], block)]


def time_of(seconds: float) -> FloatArray:
    return np.arange(round(seconds * RATE)) / RATE


@pytest.mark.parametrize(
    ("hum", "noise", "late_s"),
    [(sine(0.5), 0.007, 0.05), (sine(0.4, 60.2), 0.007, 0.05), (None, 0.4, 0.08), (sine(0.2), 0.3, 0.08)],
)
@pytest.mark.parametrize("block", [37, 400, 5000])
def test_a_fall_is_told_in_a_hum_and_in_noise(hum: Hum | None, noise: float, late_s: float, block: int) -> None:
    drop = Drop(rate_hz=RATE, settle_s=0.4)
    _, said = watched(volts(drop.time_s, -1.77 * drop.height(drop.time_s), hum, noise), block)
    since = next(state.since_index for state in said if state.moving)
    assert since is not None
    assert drop.rest_s - 0.001 < since / RATE < drop.rest_s + late_s
    assert not said[-1].moving
    assert watched(volts(time_of(1.0), hum=hum, noise=noise))[0].objection == ""


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3))])
def test_a_minute_of_noise_hum_and_drift_is_no_motion(seed: int) -> None:
    time_s, draw = time_of(60.0), np.random.default_rng(seed)
    drift = 0.3 * np.sin(2.0 * np.pi * draw.uniform(0.03, 0.3) * time_s + draw.uniform(0.0, 6.0))
    for hum, noise in ((sine(0.3, 50.0 + draw.uniform(-0.1, 0.1)), 0.01), (sine(0.3, 60.0), 0.5)):
        samples = volts(time_s, hum=hum, noise=0.0) + drift + draw.normal(0.0, noise, (4, time_s.size))
        assert not any(state.moving for state in watched(samples)[1])


@pytest.mark.parametrize(
    "hum",
    [
        lambda time_s: sine()(time_s) * (time_s < 3.0),
        lambda time_s: sine(0.2)(time_s) * (1.0 + (time_s > 3.0)),
        lambda time_s: sine(0.2, phase=np.pi / 2.0 * (time_s > 3.0))(time_s),
        lambda time_s: sine(0.2, phase=np.pi * (time_s > 3.0))(time_s),
        lambda time_s: sine(0.2)(time_s) * (1.0 + 0.3 * np.sin(2.0 * np.pi * time_s)),
        lambda time_s: sine(0.2, phase=0.6 * np.sin(time_s))(time_s),
    ],
    ids=["ends", "doubles", "jumps by a quarter", "turns over", "beats", "wanders"],
)
@pytest.mark.parametrize("noise", [0.007, 0.4])
def test_a_hum_that_changes_is_no_motion(hum: Hum, noise: float) -> None:
    assert not any(state.moving for state in watched(volts(time_of(6.0), hum=hum, noise=noise))[1])


def test_after_a_gap_in_a_motion_the_hum_does_not_keep_it_going() -> None:
    time_s = time_of(6.0)
    path_m = np.where((time_s > 3.0) & (time_s < 4.5), 0.8 * np.sin(4.0 * np.pi * (time_s - 3.0)) ** 2, 0.0)
    samples = np.delete(volts(time_s, path_m, sine()), np.s_[round(3.507 * RATE) : round(3.513 * RATE)], axis=1)
    _, said = watched(samples)
    assert any(state.moving for state in said)
    assert not said[-1].moving


@pytest.mark.parametrize(
    ("hum", "noise", "what"), [(sine(0.4, 180.0), 0.007, "a hum or a vibration"), (None, 1.5, "noise")]
)
def test_where_a_fall_may_not_be_seen_it_says_why(hum: Hum | None, noise: float, what: str) -> None:
    trigger, _ = watched(volts(time_of(3.0), hum=hum, noise=noise))
    assert trigger.disturbance == what
    assert trigger.objection.startswith("it would shake the voltages about ")
    assert trigger.objection.endswith(f" times as hard as {what} does, and the trigger asks for 8 times")


def test_without_an_echo_it_says_so() -> None:
    trigger, _ = watched(np.random.default_rng(1).normal(0.0, 0.01, (4, 60000)))
    assert trigger.objection.startswith("it would shake the voltages less hard than noise does")


def test_after_it_has_learned_anew_nothing_is_said_before_the_next_look() -> None:
    trigger, _ = watched(volts(time_of(3.0), noise=1.5))
    assert trigger.objection
    trigger.relearn()
    assert trigger.objection == ""


def test_where_no_direct_voltage_is_passed_a_motion_tells_the_echo_until_another_one_does() -> None:
    def alternating(amplitude: float) -> FloatArray:
        phase = np.where(time_of(2.0) < 0.7, 400.0 * np.pi * time_of(2.0), np.nan)
        circle = np.nan_to_num(amplitude * np.stack([np.cos(phase), np.sin(phase)] * 2))
        return np.asarray(circle + np.random.default_rng(3).normal(0.0, 0.01, circle.shape))

    silent = np.random.default_rng(1).normal(0.0, 0.01, (4, 20000))
    assert watched(np.concatenate([silent, alternating(0.3)], axis=1))[0].objection == ""
    assert watched(np.concatenate([silent, alternating(0.3), alternating(0.0)], axis=1), 5000)[0].objection == ""
    # louder things were near, but what hangs there now is seen: it has an echo of its own, a faint one
    faint = silent + 0.008
    assert watched(np.concatenate([silent, alternating(0.3), faint], axis=1))[0].objection
