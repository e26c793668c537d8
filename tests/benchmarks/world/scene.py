"""A world with one motion in it, and the record made of it with its truth."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from benchmarks.world.disturbance import Disturbance
from benchmarks.world.drop import Body, Drop
from benchmarks.world.echoes import EchoesAlong
from benchmarks.world.receiver_chain import Converter, Mixer, Noise
from benchmarks.world.room import Room
from benchmarks.world.stated import Stated

from radargui.model.recording import Digitisation, Recording, Truth, iq_names
from radargui.model.setup import Setup


@dataclass(frozen=True, kw_only=True)
class World:
    """All that is true of one record.

    Attributes
    ----------
    name
        Of the recording.
    key
        Numbers that the noise starts from.
    room, body, drop, mixers, noise, converter, phase_sign
        The noise's white part follows from `snr_db`.
    phases_rad
        Phase of each receiver's local oscillator.
    skew_in_file
        Whether the samples bring the skew, or only the setup has it.
    disturbances
        What else happens in the room and the receivers, in this order.
    """

    name: str
    key: tuple[int, ...]
    room: Room
    body: Body
    drop: Drop
    mixers: tuple[Mixer, ...]
    noise: Noise
    converter: Converter
    phase_sign: int
    phases_rad: tuple[float, ...]
    snr_db: float
    skew_in_file: bool = True
    disturbances: tuple[Disturbance, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Scene(World):
    """A world, and what its setup says of it.

    Attributes
    ----------
    seed, stated
        Which draw, and what its setup states.
    setup
        What the estimator is told.
    facts
        What was drawn, for the printed line.
    motion, falls
        Which motion, and whether the sphere flies freely in it.
    is_mistaken
        Whether the setup states something wrongly.
    """

    seed: int
    stated: Stated
    setup: Setup
    facts: dict[str, object] = field(default_factory=dict)
    motion: str = "drop"
    falls: bool = True
    is_mistaken: bool = False


@dataclass(frozen=True)
class Record:
    """What an estimator may read, and the truth."""

    scene: Scene
    recording: Recording
    truth: Truth


def make_record(scene: Scene) -> Record:
    """Return the scene's record: the rate that it states is that of the setup."""
    recording, truth = record_of(scene, scene.setup.daq.rate_hz)
    return Record(scene, recording, truth)


def record_of(world: World, stated_rate_hz: float) -> tuple[Recording, Truth]:
    """Move the sphere through the room, mix, digitise; each channel at its own times, the truth at channel 0's."""
    rng = np.random.default_rng([*world.key, 7])
    converter, drop = world.converter, world.drop
    count = int(drop.duration_s * converter.rate_hz)
    origin = np.zeros((3, 1))
    seen = EchoesAlong(world.room, drop) if drop.breaks_s else None
    volts, largest_v = np.empty((2 * len(world.mixers), count)), 0.0
    for receiver, mixer in enumerate(world.mixers):
        size = abs(world.room.direct(receiver, origin)[0]) * np.exp(-1j * world.phases_rad[receiver])
        for part in range(2):
            channel = 2 * receiver + part
            time_s = converter.times_s(count, channel)
            place = drop.position(time_s)
            received = world.room.received(receiver, place) if seen is None else seen.at(receiver, time_s, place)
            echo = received / size
            foreseen = mixer.volts(echo if world.phase_sign > 0 else echo.conj(), part)
            largest_v = max(largest_v, float(np.abs(foreseen).max()))
            for one in world.disturbances:
                echo = one.echo(receiver, time_s, place, echo)
            clean = mixer.volts(echo if world.phase_sign > 0 else echo.conj(), part)
            volts[channel] = clean + mixer.amplitude_v * world.noise.made(rng, count, converter.rate_hz)
            for one in world.disturbances:
                volts[channel] = one.volts(channel, time_s, volts[channel], mixer.amplitude_v)
    converter = converter.for_signals(largest_v)
    codes = converter.codes(volts)
    for one in world.disturbances:
        codes = one.codes(codes)
    digitisation = Digitisation(
        iq_names(len(codes) // 2),
        stated_rate_hz,
        ((0.0, converter.step_v),) * len(codes),
        converter.skew_s if world.skew_in_file else None,
        device="simulated",
    )
    gaps = tuple(gap for one in world.disturbances for gap in one.lost(converter.rate_hz))
    came = np.ones(count, dtype=bool)
    for gap in gaps:
        came[gap.first_index : gap.first_index + gap.count] = False
    place = drop.position(converter.times_s(count, 0)[came])
    times = np.array([impact.time_s for impact in drop.impacts])
    truth = Truth(place, world.room.path_m(place), times)
    return Recording(world.name, codes[:, came], digitisation, gaps), truth
