"""Draws scenes from a seed: generic or physical mismatch, all motions, receivers and levels."""

from __future__ import annotations

import numpy as np
from benchmarks.world.generic import motion as motions
from benchmarks.world.generic.mismatch import draw_floor, draw_wall, smooth_field
from benchmarks.world.generic.scene import Receiving, Scene, places

from radargui.model.radar import Radar, Receiver, Tracer, Transmitter
from radargui.model.setup import Setup

MOTIONS = ("drop", "drop", "drop", "drop", "drop", "drop", "drop", "circle", "pendulum", "bed")


def draw_scene(seed: int, kind: str, motion: str | None = None, **fixed: float) -> Scene:
    """Return the scene of a seed.

    Parameters
    ----------
    seed
        Same seed, same scene.
    kind
        "generic" (bias and amplitude smooth in position) or "physical" (mirrors, 1/f noise, drag).
    motion
        drop, circle, pendulum or bed; drawn where left out.
    fixed
        Values to hold instead of drawing: snr_db, rate_hz, skew_s, floor, wall, flicker, drag, height_m, e,
        drift_m_s, n_receivers, amplitude_v, bias, moving_s (what is recorded from the release on).
    """
    rng = np.random.default_rng([seed, 1 if kind == "physical" else 0])

    def value(name: str, drawn: float) -> float:
        return float(fixed.get(name, drawn))

    chosen = motion or str(rng.choice(MOTIONS))
    n_receivers = int(value("n_receivers", 4 if rng.random() < 0.1 else 3))
    setup = _draw_setup(rng, n_receivers)
    release = np.asarray(setup.tracer.release_position_m)
    rate = value("rate_hz", rng.choice([2000.0, 5000.0, 10000.0, 33333.0, 33333.0]))
    skew = value("skew_s", rng.choice([0.0, 5e-6, min(15e-6, 0.16 / rate), 1.0 / (2 * n_receivers * rate)]))
    physical = kind == "physical"
    drag = value("drag", rng.choice([0.0, 0.005, 0.03, 0.06]) if physical else 0.0)
    height = value("height_m", rng.uniform(0.06, 0.30))
    height = min(height, release[2] + 0.16)
    facts = {"drag_1_m": drag}
    moving = _draw_motion(
        rng,
        chosen,
        release,
        height,
        value("e", rng.uniform(0.4, 0.92)),
        drag,
        value("drift_m_s", rng.uniform(0.0, 0.08)),
        fixed.get("moving_s"),
    )
    time = np.linspace(0.0, moving.duration_s, 2000)
    lowest = float(moving.position(time)[2].min())
    planes: list = []
    if physical:
        floor = value("floor", rng.uniform(0.1, 0.3))
        wall = value("wall", rng.choice([0.0, 0.0, rng.uniform(0.02, 0.04)]))
        planes += [draw_floor(rng, floor, lowest, n_receivers)] if floor > 0 else []
        planes += [draw_wall(rng, wall, n_receivers)] if wall > 0 else []
    bias = value("bias", 0.0 if physical else rng.uniform(0.01, 0.05))
    return Scene(
        f"{kind}-{chosen}-{seed}",
        kind,
        setup,
        moving,
        tuple(_draw_receiving(rng, setup, i, bias) for i in range(n_receivers)),
        value("amplitude_v", rng.choice([0.05, 0.5, 1.0, 2.0])),
        value("snr_db", rng.uniform(20.0, 45.0)),
        rate,
        skew,
        seed,
        tuple(planes),
        value("flicker", rng.choice([0.0, 0.003, 0.006]) if physical else 0.0),
        drag_1_m=drag,
        facts=facts,
    )


def _draw_setup(rng: np.random.Generator, n_receivers: int) -> Setup:
    azimuth = (90.0 + 360.0 / n_receivers * np.arange(n_receivers) + rng.uniform(-15.0, 15.0, n_receivers)) % 360.0
    release = (float(rng.uniform(-0.02, 0.02)), float(rng.uniform(-0.02, 0.02)), float(rng.uniform(0.08, 0.14)))
    return Setup(
        schema=1,
        radar=Radar(phase_sign=int(rng.choice([-1, 1]))),
        transmitter=Transmitter(distance_m=float(rng.uniform(0.6, 0.8))),
        receiver=tuple(
            Receiver(tilt_deg=float(rng.uniform(32, 50)), azimuth_deg=float(a), distance_m=float(rng.uniform(0.6, 0.8)))
            for a in azimuth
        ),
        tracer=Tracer(release_position_m=release),
    )


def _draw_motion(rng, chosen, release, height, e, drag, drift, moving_s) -> motions.Motion:
    rest = float(rng.uniform(0.2, 0.4))
    end_s = rest + (moving_s or {"drop": 0.9, "bed": 0.6}.get(chosen, 2.0))
    if chosen == "drop":
        return motions.drop(
            rng,
            release_m=release,
            height_m=height,
            restitution=e,
            drag_1_m=drag,
            drift_m_s=drift,
            rest_s=rest,
            duration_s=end_s,
        )
    if chosen == "bed":
        return motions.bed(
            release_m=release,
            height_m=height,
            depth_m=float(rng.uniform(0.01, 0.03)),
            rest_s=rest,
            duration_s=end_s,
        )
    if chosen == "circle":
        return motions.circle(
            release_m=release,
            radius_m=float(rng.uniform(0.04, 0.1)),
            rest_s=rest,
            duration_s=end_s,
            period_s=float(rng.uniform(0.8, 2.0)),
            slope=float(rng.uniform(-0.4, 0.4)),
        )
    return motions.pendulum(
        release_m=release,
        length_m=float(rng.uniform(0.4, 0.8)),
        rest_s=rest,
        duration_s=end_s,
        amplitude_rad=float(rng.uniform(0.05, 0.12)),
        azimuth_rad=float(rng.uniform(0, 6.28)),
    )


def _draw_receiving(rng: np.random.Generator, setup: Setup, receiver: int, bias: float) -> Receiving:
    tx, receivers = places(setup)
    rx = receivers[receiver]
    ripple = smooth_field(rng, 0.03, 0.35)
    aim = rng.uniform(4.0, 16.0)

    def amplitude(p):
        out = 1.0 + ripple(p)
        for antenna in (tx, rx):
            away = p - antenna[:, None]
            distance = np.linalg.norm(away, axis=0)
            cosine = (-antenna / np.linalg.norm(antenna)) @ away / distance
            out = out * np.linalg.norm(antenna) / distance * cosine**aim
        return out

    return Receiving(
        amplitude,
        smooth_field(rng, bias),
        smooth_field(rng, bias),
        float(rng.uniform(0.85, 1.15)),
        float(np.radians(rng.uniform(-10, 10))),
        tuple(float(v) for v in rng.uniform(-0.5, 0.5, 2)),
        float(rng.uniform(0, 2 * np.pi)),
    )
