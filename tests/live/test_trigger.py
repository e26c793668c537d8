"""The motion trigger, causal, block by block."""

from __future__ import annotations

import numpy as np
from support.drops import Drop

from radargui.live.trigger import MotionTrigger, TriggerState
from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation

RATE = 20000.0


def states(volts: FloatArray, block: int = 400) -> list[TriggerState]:
    trigger = MotionTrigger(Digitisation(("I1", "Q1"), RATE), threshold=8.0)
    return [trigger.push(volts[:, begin : begin + block]) for begin in range(0, volts.shape[1], block)]


def drop_volts(drop: Drop, hum: float = 0.0) -> FloatArray:
    phase = -2 * np.pi * 1.77 * drop.height(drop.time_s) / 0.03
    z = np.stack([np.cos(phase), np.sin(phase)]) + hum * np.sin(2 * np.pi * 50 * drop.time_s)
    return np.asarray(z + np.random.default_rng(0).normal(0, 0.007, z.shape))


def test_after_the_last_bounce_it_is_quiet() -> None:
    drop = Drop(rate_hz=RATE)
    last = states(drop_volts(drop))[-1]
    assert not last.moving
    assert last.quiet_since_index is not None
    assert drop.impact_s[-10] < last.quiet_since_index / RATE < drop.impact_s[-1] + 0.05


def test_motion_is_not_told_before_the_quiet_level_is_known() -> None:
    time = np.arange(1000) / RATE
    assert not any(state.ready for state in states(np.stack([np.cos(900 * time), np.sin(900 * time)])))


def test_motion_is_told_where_the_shaking_reaches_the_threshold_and_never_below_it() -> None:
    drop = Drop(rate_hz=RATE, settle_s=0.3)
    trigger, volts, told = MotionTrigger(Digitisation(("I1", "Q1"), RATE), threshold=8.0), drop_volts(drop), []
    for begin in range(0, volts.shape[1], 400):
        state = trigger.push(volts[:, begin : begin + 400])
        told.append((begin / RATE, state.moving, trigger.shaking))
    known = [one for one in told if np.isfinite(one[2])]
    assert len(known) < len(told)
    rest = [shaking for at_s, _, shaking in known if at_s < drop.rest_s - 0.05]
    assert 0.5 < min(rest) <= max(rest) < 3.0
    # motion is confirmed for 4 ms, a fifth of a block: it is told within the block after at the latest
    begins = next(number for number, (_, moving, _) in enumerate(known) if moving)
    assert max(shaking for *_, shaking in known[begins - 1 : begins + 1]) > 8.0
    assert all(shaking < 8.0 for *_, shaking in known[: begins - 1])
