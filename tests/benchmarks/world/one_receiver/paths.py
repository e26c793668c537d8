"""How targets move: Doppler against time of toy cars, plates, pendulums, walkers; their path is its integral."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import cumulative_trapezoid

from radargui.model.arrays import FloatArray

Family = Callable[[np.random.Generator, FloatArray, float], FloatArray]


def slow(rng: np.random.Generator, time_s: FloatArray, fastest_hz: float) -> FloatArray:
    """Return a smooth random curve within +-1: four sines below `fastest_hz`, shape (n_samples,)."""
    frequency_hz = rng.uniform(0.1, 1.0, 4) * fastest_hz
    start_rad = rng.uniform(0.0, 2.0 * np.pi, 4)
    return np.asarray(
        np.mean([np.sin(2 * np.pi * f * time_s + s) for f, s in zip(frequency_hz, start_rad, strict=True)], 0)
    )


def _smooth_step(time_s: FloatArray, begin_s: float, length_s: float) -> FloatArray:
    """Return 0 before, 1 after, and half a cosine between: a force that sets in and ends without a jerk."""
    share = np.clip((time_s - begin_s) / length_s, 0.0, 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * share))


def car(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a car in motion from the first sample to the last, its speed nearly constant."""
    return peak_hz * (0.9 + 0.1 * slow(rng, time_s, 1.0))


def start(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a car that rests, starts, and goes on."""
    begin_s = rng.uniform(0.2, 0.4) * time_s[-1]
    return _smooth_step(time_s, begin_s, rng.uniform(0.05, 0.5)) * car(rng, time_s, peak_hz)


def stop(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a car in motion from the first sample that stops."""
    begin_s = rng.uniform(0.5, 0.7) * time_s[-1]
    return (1.0 - _smooth_step(time_s, begin_s, rng.uniform(0.05, 0.3))) * car(rng, time_s, peak_hz)


def plate(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a plate driven to and fro: constant speed, turned round within a tenth of a stroke."""
    stroke_s = max(time_s[-1] / rng.uniform(1.5, 6.0), 8.0 / peak_hz)
    wave = np.sin(np.pi * (time_s / stroke_s + rng.uniform(0.0, 1.0)))
    return peak_hz * np.clip(wave / 0.2, -1.0, 1.0)


def pendulum(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a pendulum of 0.15 to 1 m (0.8 to 2 s a swing) that loses amplitude."""
    period_s = rng.uniform(0.8, 2.0)
    loss = np.exp(-time_s / rng.uniform(4.0, 20.0))
    return peak_hz * loss * np.cos(2.0 * np.pi * time_s / period_s + rng.uniform(0.0, 2.0 * np.pi))


def walker(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a walker's body: its speed swings by a fifth with each of about two steps a second."""
    step_hz = rng.uniform(1.6, 2.2)
    return peak_hz * (0.8 + 0.2 * np.cos(2.0 * np.pi * step_hz * time_s + rng.uniform(0.0, 6.0)))


def passing(rng: np.random.Generator, time_s: FloatArray, peak_hz: float) -> FloatArray:
    """Return a car that passes beside the radar: r = sqrt(d^2 + v^2 t^2), Doppler through zero."""
    middle_s = rng.uniform(0.35, 0.65) * time_s[-1]
    beside_s = rng.uniform(0.1, 0.3) * time_s[-1]  # d / v
    late_s = time_s - middle_s
    return peak_hz * late_s / np.hypot(beside_s, late_s)


FAMILIES: dict[str, Family] = {
    "car": car,
    "start": start,
    "stop": stop,
    "plate": plate,
    "pendulum": pendulum,
    "walker": walker,
    "passing": passing,
}


def draw_turns(
    rng: np.random.Generator, time_s: FloatArray, peak_hz: float, families: tuple[str, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return Doppler in Hz and path in wavelengths, shape (n_samples,), of one of the families, to or fro."""
    family = FAMILIES[families[int(rng.integers(len(families)))]]
    doppler_hz = family(rng, time_s, peak_hz) * rng.choice([-1.0, 1.0])
    return doppler_hz, cumulative_trapezoid(doppler_hz, time_s, initial=0.0)
