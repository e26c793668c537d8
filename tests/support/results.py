"""Run results made by hand: a sphere that falls and bounces exactly, seen by perfect receivers."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from support.small_setups import quick_setup

from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.model.arrays import FloatArray
from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import as_stored
from radargui.model.recording import Digitisation, Gap, Recording, iq_names
from radargui.model.result import (
    Bounce,
    Bounces,
    CorrectedIQ,
    FreeFall,
    PathLengths,
    RunResult,
    Segment,
    Track,
)
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget
from radargui.physics.path_length import path_lengths, place_antennas

G = 9.81
REST_S = 0.3
BUDGET = UncertaintyBudget(
    BudgetLine(4e-5, 4e-4, 1e-4, 4.1e-4), BudgetLine(1e-4, 2e-4, 1e-5, 2.2e-4), BudgetLine(0.003, 0.004, None, 0.005)
)


def default_setup() -> Setup:
    """The shipped setup."""
    return quick_setup()


def bouncing_height(t: FloatArray, height_m: float, e: float) -> tuple[FloatArray, list[float], list[float]]:
    """Height above the floor, impact times and the speeds before each impact, for a drop at t = 0."""
    z = np.where(t < 0, height_m, 0.0)
    start, speed, times, speeds = 0.0, 0.0, [], []
    fall = np.sqrt(2.0 * height_m / G)
    inside = (t >= 0) & (t < fall)
    z[inside] = height_m - 0.5 * G * t[inside] ** 2
    start, speed = fall, float(np.sqrt(2.0 * G * height_m))
    while speed > 0.2:
        times.append(start)
        speeds.append(speed)
        speed *= e
        end = start + 2.0 * speed / G
        inside = (t >= start) & (t < end)
        z[inside] = speed * (t[inside] - start) - 0.5 * G * (t[inside] - start) ** 2
        start = end
    return z, times, speeds


def drop_result(
    *,
    rate_hz: float = 20_000.0,
    seconds: float = 1.6,
    e: float = 0.8,
    seed: int = 1,
    gap: Gap | None = None,
    n_receivers: int = 3,
    name: str = "run-0001",
) -> RunResult:
    """A whole result of an exact drop from the release to the floor of the shipped setup, with a little noise."""
    setup = default_setup()
    setup = setup.model_copy(update={"receiver": setup.receiver[:n_receivers]})
    rng = np.random.default_rng(seed)
    index = np.arange(round(rate_hz * seconds))
    if gap is not None:
        index = index[(index < gap.first_index) | (index >= gap.first_index + gap.count)]
    t = index / rate_hz
    release = np.array(setup.tracer.release_position_m)
    floor = setup.floor.height_m or 0.0
    height, impacts, speeds = bouncing_height(t - REST_S, release[2] - floor, e)
    position = np.stack([0.02 * np.maximum(t - REST_S, 0.0), np.zeros_like(t), floor + height])
    antennas = place_antennas(setup)
    change = path_lengths(position, antennas) - path_lengths(release[:, None], antennas)
    phase = 2.0 * np.pi * change / setup.radar.wavelength_m
    noise = rng.normal(0.0, 0.005, (2, n_receivers, t.size))
    i, q = np.cos(phase) + noise[0], np.sin(phase) + noise[1]
    volts = np.empty((2 * n_receivers, t.size))
    volts[0::2] = 0.05 + (1.0 + 0.1 * height) * i
    volts[1::2] = -0.1 + 0.9 * (q * np.cos(0.1) + i * np.sin(0.1))
    valid = np.ones((n_receivers, t.size), dtype=np.bool_)
    u = np.full((n_receivers, t.size), 2.4e-5)
    segment = Segment(int(np.searchsorted(t, REST_S)), int(np.searchsorted(t, seconds - 0.15)), 0, int(0.28 * rate_hz))
    recording = Recording(
        name, volts, Digitisation(iq_names(n_receivers), rate_hz, device="made by hand"), (gap,) if gap else ()
    )
    steps = tuple(
        PublishedSteps(*(_steps(volts[2 * k + part], segment) for part in (0, 1))) for k in range(n_receivers)
    )
    channels = tuple(
        ChannelQuality(str(k + 1), 41.3, 0.0052, 38.0, 27.5, 1.0, 0.0, 0.93, 5.7) for k in range(n_receivers)
    )
    bounces = tuple(
        Bounce(REST_S + when, speed, speed * e, e, 0.0012, "hand", True)
        for when, speed in zip(impacts, speeds, strict=True)
    )
    fall = FreeFall(
        9.8123, 0.0034, 0.32, REST_S + impacts[0] - 0.01, release[2], release[2] - floor, (0.0, 0.0, 0.0), 3e-5
    )
    tau = fall.first_time_s - REST_S
    parabola = (release[2] - 0.5 * G * tau**2, -G * tau, -0.5 * G)
    track = Track(t, position, np.full((3, t.size), 4e-5), valid.all(axis=0), "exact") if n_receivers >= 3 else None
    return RunResult(
        recording,
        setup,
        "ok",
        segment=segment,
        corrected=CorrectedIQ(t, i, q, valid, np.full(i.shape, 0.005), "published", channels, steps),
        paths=PathLengths(t, phase, change, u, valid),
        track=track,
        bounces=Bounces(bounces, replace(fall, parabola=parabola)) if track else Bounces(),
        uncertainty_budget=BUDGET,
        findings=(
            as_stored("the antennas' own uncertainty is not known" if gap is None else "30 ms of samples were lost"),
        ),
    )


def quiet_result(n_receivers: int = 3, samples: int = 1000) -> RunResult:
    """Nothing moves."""
    rng = np.random.default_rng(2)
    recording = Recording(
        "quiet", rng.normal(0.0, 0.01, (2 * n_receivers, samples)), Digitisation(iq_names(n_receivers), 1000.0)
    )
    return RunResult(
        recording, default_setup(), "no_motion", findings=(as_stored("nothing moves in this recording", "refuse"),)
    )


def rejected_result(samples: int = 1000) -> RunResult:
    """Too weak to say anything."""
    return replace(
        quiet_result(samples=samples), status="rejected", findings=(as_stored("receiver 2: no signal", "refuse"),)
    )


def _steps(volts: FloatArray, segment: Segment) -> ChannelSteps:
    x = volts[segment.first : segment.last]
    middle = 0.5 * (x.max() + x.min())
    sign = x > middle + 0.01
    turns = np.flatnonzero(sign[1:] != sign[:-1]) + 1
    edges = np.concatenate([[0], turns, [x.size]])
    pieces = [(int(a), int(b)) for a, b in pairwise(edges) if b - a > 20]
    peaks = np.array([a + int(x[a:b].argmax()) for a, b in pieces if x[(a + b) // 2] > middle], dtype=np.intp)
    valleys = np.array([a + int(x[a:b].argmin()) for a, b in pieces if x[(a + b) // 2] <= middle], dtype=np.intp)
    upper = np.interp(np.arange(x.size), peaks, x[peaks])
    lower = np.interp(np.arange(x.size), valleys, x[valleys])
    bias = np.full(volts.size, middle)
    bias[segment.first : segment.last] = 0.5 * (upper + lower)
    scale = np.full(volts.size, 0.5 * float(np.ptp(x)))
    scale[segment.first : segment.last] = 0.5 * (upper - lower)
    first = segment.first
    return ChannelSteps(segment, peaks + first, valleys + first, upper, lower, bias, turns + first, scale)
