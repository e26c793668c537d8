"""Drops of a sphere before three or four receivers, some with a channel that is broken: physics and wiring only.

The sphere hangs, falls freely, bounces off the floor with a coefficient of restitution, and drifts to the side; the
path of receiver i is `|p - tx| + |p - rx_i|`, its amplitude goes with `1 / (r_tx r_rx)` (radar equation, amplitudes).
Channel k is sampled k times the multiplexer's delay later than channel 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.one_receiver.disturbances import Mixer

from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation, Recording, iq_names
from radargui.model.setup import Setup

G_M_S2 = 9.81
RATE_HZ = 33333.0
RANGE_V = 5.0
RELEASE_M = (0.0, 0.0, 0.12)
FLOOR_M = -0.14
SKEW_S = 5.0e-6
ANTENNA_M = 0.70
TILT_DEG = 40.0
LAST_SPEED_M_S = 0.05
"""A rebound slower than this is no more one: the sphere stays on the floor."""

BROKEN = ("dead", "dead with noise", "copied", "swapped", "doubled cable", "constant", "clipped")
WHOLE = "whole"


@dataclass(frozen=True, slots=True)
class Drop:
    """A recording and the truth: position shape (3, n_samples), receivers whose signals are wrong (from 0)."""

    name: str
    kind: str
    recording: Recording
    setup: Setup
    position_m: FloatArray
    moving: tuple[int, int]
    wrong: frozenset[int]


@dataclass(frozen=True, slots=True)
class _Flight:
    begin_s: float
    position_m: FloatArray
    velocity_m_s: FloatArray


def drop_setup(n_receivers: int, correction: str = "joint") -> Setup:
    """Return the laboratory's geometry: receivers 40 degrees off the axis, evenly around it."""
    azimuths_deg = [90.0 + 360.0 * number / n_receivers for number in range(n_receivers)]
    return Setup.model_validate(
        {
            "schema": 1,
            "radar": {"frequency_hz": 10.0e9, "phase_sign": 1},
            "transmitter": {"distance_m": ANTENNA_M},
            "receiver": [{"tilt_deg": TILT_DEG, "azimuth_deg": a, "distance_m": ANTENNA_M} for a in azimuths_deg],
            "tracer": {"diameter_m": 0.010, "release_position_m": list(RELEASE_M)},
            "floor": {"height_m": FLOOR_M, "normal": [0.0, 0.0, 1.0]},
            "daq": {"rate_hz": RATE_HZ, "range_v": RANGE_V, "channel_skew_s": SKEW_S},
            "processing": {"correction": correction, "geometry": "exact"},
        }
    )


def make_drop(seed: int, kind: str, n_receivers: int = 3) -> Drop:
    """Return one seeded drop, broken as the kind says; a seed falls alike whatever is broken."""
    rng = np.random.default_rng([seed, n_receivers])
    setup = drop_setup(n_receivers)
    rest_s = rng.uniform(0.3, 0.6)
    flights = _flights(rng, rest_s)
    duration_s = min(flights[-1].begin_s + 0.3, rest_s + 2.0)
    time_s = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    noise_db, amplitude_v = rng.uniform(30.0, 45.0), rng.uniform(0.8, 2.0, n_receivers)
    mixers = [
        Mixer(float(np.exp(rng.uniform(-0.15, 0.15))), float(np.deg2rad(rng.uniform(-10, 10))))
        for _ in range(n_receivers)
    ]
    start_turns, offset_v = rng.uniform(0.0, 1.0, n_receivers), rng.uniform(-0.3, 0.3, 2 * n_receivers)
    noise = rng.standard_normal((2 * n_receivers, len(time_s)))

    def wave(channel: int, at_channel: int) -> FloatArray:
        """Return what the cable of a channel carries when `at_channel` is sampled, shape (n_samples,)."""
        receiver, part = divmod(channel, 2)
        path_m, strength = _path(_position(flights, time_s + at_channel * SKEW_S), TILT_DEG, receiver, n_receivers)
        turns = path_m / setup.radar.wavelength_m + start_turns[receiver]
        size_v = amplitude_v[receiver] * strength
        sigma_v = amplitude_v[receiver] / np.sqrt(2.0 * 10.0 ** (noise_db / 10.0))
        clean = mixers[receiver].echo(size_v, turns, turns)[part]
        return np.asarray(clean + offset_v[channel] + sigma_v * noise[channel])

    volts = np.array([wave(channel, channel) for channel in range(2 * n_receivers)])
    bad = int(rng.integers(n_receivers))
    other = int((bad + rng.integers(1, n_receivers)) % n_receivers)
    part = int(rng.integers(2))
    target, source = 2 * bad + part, 2 * other + part
    wrong = {bad}
    if kind == "dead":
        volts[target] = 0.0
    elif kind == "dead with noise":
        volts[target] = 0.001 + 0.0005 * noise[target]
    elif kind == "copied":
        volts[2 * bad + 1] = wave(2 * bad, 2 * bad + 1)
    elif kind == "swapped":
        volts[target], volts[source] = wave(source, target), wave(target, source)
        wrong = {bad, other}
    elif kind == "doubled cable":
        volts[target] = wave(source, target)
    elif kind == "constant":
        volts[target] = rng.uniform(-2.0, 2.0)
    elif kind == "clipped":
        # the echo halves on the way down: so low it is clipped at the floor too
        limit_v = rng.uniform(0.25, 0.45) * amplitude_v[bad]
        volts[target] = offset_v[target] + np.clip(volts[target] - offset_v[target], -limit_v, limit_v)
    elif kind == WHOLE:
        wrong = set()
    else:
        raise ValueError(kind)
    step_v = 2.0 * RANGE_V / 65536
    codes = np.clip(np.round(volts / step_v), -32768, 32767).astype(np.int16)
    scaling = ((0.0, step_v),) * (2 * n_receivers)
    digitisation = Digitisation(iq_names(n_receivers), RATE_HZ, scaling, SKEW_S, device="simulated")
    name = f"{kind}, {n_receivers} receivers, seed {seed}"
    end = min(round(flights[-1].begin_s * RATE_HZ), len(time_s))
    return Drop(
        name=name,
        kind=kind,
        recording=Recording(f"drop-{kind.replace(' ', '-')}-{seed}", codes, digitisation),
        setup=setup,
        position_m=_position(flights, time_s),
        moving=(round(rest_s * RATE_HZ), end),
        wrong=frozenset(wrong),
    )


def _flights(rng: np.random.Generator, rest_s: float) -> list[_Flight]:
    """Return the flights: the fall, the bounces, and a last one without speed, on the floor."""
    restitution = rng.uniform(0.6, 0.9)
    lateral_m_s = np.append(rng.uniform(-0.05, 0.05, 2), 0.0)
    flights = [_Flight(rest_s, np.array(RELEASE_M), lateral_m_s)]
    fall_s = np.sqrt(2.0 * (RELEASE_M[2] - FLOOR_M) / G_M_S2)
    speed_m_s, at_s = G_M_S2 * fall_s, rest_s + fall_s
    place_m = np.append(np.array(RELEASE_M)[:2] + lateral_m_s[:2] * fall_s, FLOOR_M)
    while (speed_m_s := speed_m_s * restitution) > LAST_SPEED_M_S:
        lateral_m_s = 0.8 * lateral_m_s + np.append(rng.uniform(-0.03, 0.03, 2), 0.0)
        flights.append(_Flight(at_s, place_m, lateral_m_s + np.array([0.0, 0.0, speed_m_s])))
        flight_s = 2.0 * speed_m_s / G_M_S2
        place_m, at_s = place_m + lateral_m_s * flight_s, at_s + flight_s
    return [*flights, _Flight(at_s, place_m, np.zeros(3))]


def _position(flights: list[_Flight], time_s: FloatArray) -> FloatArray:
    position_m = np.tile(np.array(RELEASE_M)[:, None], (1, len(time_s)))
    for flight in flights:
        on = time_s >= flight.begin_s
        late_s = time_s[on] - flight.begin_s
        position_m[:, on] = flight.position_m[:, None] + flight.velocity_m_s[:, None] * late_s
        if flight.velocity_m_s.any() or flight is flights[0]:
            position_m[2, on] -= 0.5 * G_M_S2 * late_s**2
    return position_m


def _path(position_m: FloatArray, tilt_deg: float, receiver: int, n_receivers: int) -> tuple[FloatArray, FloatArray]:
    """Return the path in m and the strength of the echo (1 at the release), each shape (n_samples,)."""
    tilt, azimuth = np.deg2rad(tilt_deg), np.deg2rad(90.0 + 360.0 * receiver / n_receivers)
    out = ANTENNA_M * np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
    to_tracer_m = np.linalg.norm(position_m - np.array([[0.0], [0.0], [ANTENNA_M]]), axis=0)
    to_receiver_m = np.linalg.norm(position_m - out[:, None], axis=0)
    product = to_tracer_m * to_receiver_m
    return to_tracer_m + to_receiver_m, product[0] / product
