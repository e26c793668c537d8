"""Cost of the adaptive and joint estimates: time and memory by scene, by length of the record, by sample rate.

python3 packaging/dev.py bench cost [--part scenes lengths rates] [--repeats 3] [--seconds 1 10 100] [--rates 2e3 1e6]
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchmarks.accuracy import with_method
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.motion import Motion
from benchmarks.world.generic.scene import Scene, make_record
from support.estimates import joint_of, rounds_of
from threadpoolctl import threadpool_limits

from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.processing.process import process

RATE_HZ = 33333.0
FIXED = {
    "height_m": 0.2,
    "e": 0.75,
    "drift_m_s": 0.03,
    "snr_db": 35.0,
    "rate_hz": RATE_HZ,
    "skew_s": 1e-7,  # six channels fit into a sample at 1 MS/s
    "amplitude_v": 1.0,
    "n_receivers": 3,
    "flicker": 0.0,
    "drag": 0.0,
}
SCENES: dict[str, tuple[str, int, dict[str, float]]] = {
    "generic": ("generic", 3, {}),
    "floor": ("physical", 4, {"floor": 0.2, "wall": 0.0}),
    "wall": ("physical", 5, {"floor": 0.0, "wall": 0.04}),
    "floor and wall": ("physical", 6, {"floor": 0.2, "wall": 0.03}),
    "floor, 1/f, drag": ("physical", 6, {"floor": 0.2, "wall": 0.0, "flicker": 0.006, "drag": 0.03}),
}
BACK_S, HANG_S = 0.5, 0.1
MAX_GROWTH = 2.0
"""A second of the longest record may cost so many times a second of the shortest, 1 MS/s so many times 33 kS/s."""


@dataclass(frozen=True)
class Cost:
    """What one method took for one record: the best of some runs, and the peak of the process's whole memory."""

    wall_s: float
    cpu_s: float
    peak_mb: float
    said: str


def _adaptive(recording: Recording, setup: Setup) -> str:
    with threadpool_limits(limits=1, user_api="blas"):
        estimate_adaptive(rounds_of(recording, setup))
    return ""


def _joint(recording: Recording, setup: Setup) -> str:
    with threadpool_limits(limits=1, user_api="blas"):
        choices = joint_of(recording, setup).choices
    reflectors = [name for name in ("floor", "wall") if any(f"A {name} that reflects is kept" in c for c in choices)]
    searched = any("wall" in choice for choice in choices)
    return f"{' and '.join(reflectors) or 'no reflector'}{', walls searched' if searched else ''}"


def _process(recording: Recording, setup: Setup) -> str:
    result = process(recording, with_method(setup, "joint-exact"))
    method = result.corrected.method if result.corrected is not None else "-"
    return f"{result.status} by {method}, {len(result.bounces.impacts)} impacts"


METHODS: dict[str, Callable[[Recording, Setup], str]] = {
    "adaptive": _adaptive,
    "joint": _joint,
    "process": _process,
}


def scene_named(name: str, **other: float) -> Scene:
    """Return one of the scenes, with other values where wanted."""
    kind, seed, fixed = SCENES[name]
    return draw_scene(seed, kind, "drop", **{**FIXED, **fixed, **other})


def lengthened(scene: Scene, seconds: float) -> Scene:
    """Return a scene whose motion is repeated: after each drop the sphere is carried back and dropped again."""
    once = scene.motion
    period = once.duration_s + BACK_S + HANG_S
    count = max(1, round(seconds / period))
    end, step = once.duration_s, 1e-4
    last, before, first = (once.position(np.array([t])) for t in (end - step, end - 2.0 * step, 0.0))
    velocity = (last - before) / step

    def position(t: np.ndarray) -> np.ndarray:
        own = t % period
        drop = once.position(np.minimum(own, end - step))
        u = np.clip((own - end + step) / BACK_S, 0.0, 1.0)
        away = last * (1.0 + 2.0 * u) * (1.0 - u) ** 2 + velocity * BACK_S * u * (1.0 - u) ** 2
        return np.where(own < end - step, drop, away + first * u**2 * (3.0 - 2.0 * u))

    duration = once.duration_s if count == 1 else count * period
    return replace(scene, motion=Motion(position, duration, once.motion_start_s))


def cost(scene: Scene, repeats: int, methods: list[str]) -> dict[str, Cost]:
    """Measure each method in a process of its own."""
    record = make_record(scene)
    context = multiprocessing.get_context("spawn")
    out = {}
    for method in methods:
        here, there = context.Pipe()
        process = context.Process(target=_measure, args=(record.recording, record.setup, method, repeats, there))
        process.start()
        there.close()
        out[method] = here.recv()
        process.join()
    return out


def _measure(recording: Recording, setup: Setup, method: str, repeats: int, pipe: Any) -> None:
    wall, cpu, said = [], [], ""
    for _ in range(repeats):
        begun, worked = time.perf_counter(), time.process_time()
        said = METHODS[method](recording, setup)
        wall.append(time.perf_counter() - begun)
        cpu.append(time.process_time() - worked)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    pipe.send(Cost(min(wall), min(cpu), peak / 1024.0, said))


def by_scene(repeats: int, methods: list[str]) -> None:
    """Print the cost of records of 1.2 s at 33 kS/s."""
    print(f"{'1.2 s, 33 kS/s':20}{'method':10}{'wall s':>8}{'cpu s':>8}{'MB':>7}")
    for name in SCENES:
        for method, one in cost(scene_named(name), repeats, methods).items():
            print(f"{name:20}{method:10}{one.wall_s:8.2f}{one.cpu_s:8.2f}{one.peak_mb:7.0f}  {one.said}", flush=True)


def by_length(seconds: list[float], repeats: int, methods: list[str]) -> float:
    """Print the cost of the same motion repeated; return the largest growth of the time for a second."""
    print(f"{'length s':20}{'method':10}{'wall s':>8}{'cpu s':>8}{'MB':>7}{'cpu s/s':>9}{'growth':>8}")
    first: dict[str, float] = {}
    growth = 1.0
    for length in sorted(seconds):
        scene = lengthened(scene_named("floor"), length)
        length = scene.motion.duration_s
        for method, one in cost(scene, repeats if length < 20.0 else 1, methods).items():
            ratio = one.cpu_s / length / first.setdefault(method, one.cpu_s / length)
            growth = max(growth, ratio)
            print(
                f"{length:<20.1f}{method:10}{one.wall_s:8.2f}{one.cpu_s:8.2f}{one.peak_mb:7.0f}"
                f"{one.cpu_s / length:9.2f}{ratio:8.2f}  {one.said}",
                flush=True,
            )
    return growth


def by_rate(rates_hz: list[float], repeats: int, methods: list[str]) -> float:
    """Print the cost of the same scene at other rates; return the largest ratio of any above 33 kS/s to it.

    The adaptive estimate alone does not count: at 1 MS/s it is mostly what is written for each sample.
    """
    print(f"{'rate kS/s':20}{'method':10}{'wall s':>8}{'cpu s':>8}{'MB':>7}{'to 33 kS/s':>12}")
    usual = {method: one.cpu_s for method, one in cost(scene_named("floor"), repeats, methods).items()}
    growth = 1.0
    for rate in sorted(rates_hz):
        for method, one in cost(scene_named("floor", rate_hz=rate), repeats, methods).items():
            ratio = one.cpu_s / usual[method]
            growth = max(growth, ratio if rate > RATE_HZ and method != "adaptive" else 1.0)
            print(
                f"{rate / 1e3:<20.0f}{method:10}{one.wall_s:8.2f}{one.cpu_s:8.2f}{one.peak_mb:7.0f}{ratio:12.2f}"
                f"  {one.said}",
                flush=True,
            )
    return growth


def main() -> int:
    """Print the tables; 1 where cost grows faster than the record or with the rate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", choices=("scenes", "lengths", "rates"), nargs="+")
    parser.add_argument("--method", choices=tuple(METHODS), nargs="+", default=list(METHODS))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--seconds", type=float, nargs="+", default=[1.0, 10.0])
    parser.add_argument("--rates", type=float, nargs="+", default=[2e3, 5e3, 33333.0, 2e5, 1e6])
    options = parser.parse_args()
    parts, growth = options.part or ["scenes", "lengths", "rates"], [1.0]
    if "scenes" in parts:
        by_scene(options.repeats, options.method)
    if "lengths" in parts:
        growth.append(by_length(options.seconds, options.repeats, options.method))
    if "rates" in parts:
        growth.append(by_rate(options.rates, options.repeats, options.method))
    return int(max(growth) > MAX_GROWTH)


if __name__ == "__main__":
    sys.exit(main())
