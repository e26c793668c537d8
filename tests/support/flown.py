"""Tracks of which the truth is exact, with the paths that a setup makes of them, and what their flights say."""

from __future__ import annotations

import numpy as np
from support.changed import changed
from support.drops import Drop

from radargui.model.arrays import FloatArray
from radargui.model.result import PathLengths, Segment, Track
from radargui.model.setup import Setup, read_setup
from radargui.physics.path_length import path_lengths, place_antennas
from radargui.restitution.bounces import FlownTrack, find_bounces
from radargui.system.resources import default_setup_path

AIRLESS_KG_M3 = 25000.0
"""The densest sphere there may be: air does next to nothing to it."""


def setup_at(release_m: FloatArray, *, given: bool = True, density_kg_m3: float | None = AIRLESS_KG_M3) -> Setup:
    """Return the default setup with a release, a level floor that is given or not, and g of the drops."""
    setup = changed(
        read_setup(default_setup_path()),
        tracer={"release_position_m": tuple(release_m.tolist()), "density_kg_m3": density_kg_m3},
        site={"g_m_s2": 9.81, "u_g_m_s2": 0.001},
    )
    floor = setup.floor if given else type(setup.floor)(height_m=0.0)
    return setup.model_copy(update={"floor": floor})


def track_of(drop: Drop, noise_m: float = 0.0, seed: int = 0) -> tuple[Track, Segment]:
    """Return the track of a drop, the floor at z = 0, and its motion."""
    time = drop.time_s
    position = np.zeros((3, time.size))
    position[2] = drop.height(time)
    position += noise_m * np.random.default_rng(seed).normal(size=position.shape)
    segment = Segment(
        round(drop.rest_s * drop.rate_hz),
        round((drop.impact_s[-1] + 0.02) * drop.rate_hz),
        0,
        round((drop.rest_s - 0.02) * drop.rate_hz),
    )
    known = np.ones(time.size, dtype=bool)
    return Track(time, position, np.full_like(position, max(noise_m, 1e-9)), known, "exact"), segment


def paths_of(track: Track, setup: Setup) -> PathLengths:
    """Return the paths that antennas of a setup see of a track."""
    antennas = place_antennas(setup)
    release = np.array(setup.tracer.release_position_m)[:, None]
    change = path_lengths(track.position_m, antennas) - path_lengths(release, antennas)
    valid = np.broadcast_to(track.valid, change.shape)
    return PathLengths(track.time_s, change, change, np.full_like(change, 1e-5), valid)


def flown(track: Track, segment: Segment, rate_hz: float, setup: Setup | None = None) -> FlownTrack:
    """Return what the flights of a track say, seen and located with one setup."""
    setup = setup_at(track.position_m[:, 0]) if setup is None else setup
    return find_bounces(track, paths_of(track, setup), segment, setup, rate_hz)
