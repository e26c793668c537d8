"""Drops of the accuracy benchmark with a broken channel: smooth bias, or a floor that reflects, 1/f noise and drag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from benchmarks.world.broken.drops import WHOLE, Drop
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import make_record

from radargui.model.arrays import FloatArray


def make_scene_drop(seed: int, kind: str, n_receivers: int, mismatch: str) -> Drop:
    """Return a drop of `draw_scene` (mismatch generic or physical) with one channel broken as the kind says."""
    record = make_record(draw_scene(seed, mismatch, "drop", n_receivers=n_receivers))
    rng = np.random.default_rng([seed, n_receivers, 5])
    recording, impacts = record.recording, record.scene.motion.impacts
    volts = recording.volts()
    first = round(record.scene.motion.motion_start_s * record.scene.rate_hz)
    last = round(impacts[-1].time_s * record.scene.rate_hz) if impacts else recording.n_samples
    bad = int(rng.integers(n_receivers))
    other = int((bad + rng.integers(1, n_receivers)) % n_receivers)
    target, source = 2 * bad + int(rng.integers(2)), 2 * other + int(rng.integers(2))
    wrong = {bad, other} if kind == "swapped" else set() if kind == WHOLE else {bad}
    _break(volts, kind, target, source, slice(first, last), rng)
    step_v = record.scene.range_v / 32768.0
    codes = np.clip(np.round(volts / step_v), -32768, 32767).astype(np.int16)
    return Drop(
        name=f"{kind}, {n_receivers} receivers, {mismatch} {seed}",
        kind=kind,
        recording=replace(recording, raw=codes),
        setup=record.setup,
        position_m=record.truth.position_m,
        moving=(first, last),
        wrong=frozenset(wrong),
    )


def _break(volts: FloatArray, kind: str, target: int, source: int, moving: slice, rng: np.random.Generator) -> None:
    """Break a channel in place; a cable on two inputs brings its own noise to both."""
    pair = target - target % 2
    if kind == "dead":
        volts[target] = 0.0
    elif kind == "dead with noise":
        volts[target] = 0.001 + 0.0005 * rng.standard_normal(volts.shape[1])
    elif kind == "copied":
        volts[pair + 1] = volts[pair]
    elif kind == "swapped":
        volts[[target, source]] = volts[[source, target]]
    elif kind == "doubled cable":
        volts[target] = volts[source]
    elif kind == "constant":
        volts[target] = rng.uniform(-2.0, 2.0)
    elif kind == "clipped":
        low, high = np.quantile(volts[target, moving], [0.02, 0.98])
        limit_v = rng.uniform(0.25, 0.45) * 0.5 * (high - low)
        middle_v = 0.5 * (high + low)
        volts[target] = np.clip(volts[target], middle_v - limit_v, middle_v + limit_v)
