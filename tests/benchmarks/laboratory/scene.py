"""A scene of the laboratory, and the record made of it with its truth."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from benchmarks.laboratory.disturbance import Disturbance
from benchmarks.laboratory.drop import Body, Drop
from benchmarks.laboratory.receiver_chain import Converter, Mixer, Noise
from benchmarks.laboratory.room import Room
from benchmarks.laboratory.stated import Stated

from radargui.model.recording import Digitisation, Recording, Truth, iq_names
from radargui.model.setup import Setup


@dataclass(frozen=True)
class Scene:
    """All that makes one record.

    Attributes
    ----------
    name, seed, stated
        Which draw, and what its setup states.
    setup
        What the estimator is told.
    room, body, drop, mixers, noise, converter, phase_sign
        What is true; the noise's white part follows from `snr_db`.
    phases_rad
        Phase of each receiver's local oscillator.
    skew_in_file
        Whether the samples bring the skew, or only the setup has it.
    facts
        What was drawn, for the printed line.
    motion, falls
        Which motion, and whether the sphere flies freely in it.
    disturbances
        What else happens in the room and the receivers, in this order.
    is_mistaken
        Whether the setup states something wrongly.
    """

    name: str
    seed: int
    stated: Stated
    setup: Setup
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
    facts: dict[str, object] = field(default_factory=dict)
    motion: str = "drop"
    falls: bool = True
    disturbances: tuple[Disturbance, ...] = ()
    is_mistaken: bool = False


@dataclass(frozen=True)
class Record:
    """What an estimator may read, and the truth."""

    scene: Scene
    recording: Recording
    truth: Truth


def make_record(scene: Scene) -> Record:
    """Move the sphere through the room, mix, digitise; each channel at its own times."""
    rng = np.random.default_rng([scene.seed, 7])
    converter, drop = scene.converter, scene.drop
    count = int(drop.duration_s * converter.rate_hz)
    origin = np.zeros((3, 1))
    volts = np.empty((2 * len(scene.mixers), count))
    for receiver, mixer in enumerate(scene.mixers):
        size = abs(scene.room.direct(receiver, origin)[0]) * np.exp(-1j * scene.phases_rad[receiver])
        for part in range(2):
            channel = 2 * receiver + part
            time_s = converter.times_s(count, channel)
            place = drop.position(time_s)
            echo = scene.room.received(receiver, place) / size
            for one in scene.disturbances:
                echo = one.echo(receiver, time_s, place, echo)
            clean = mixer.volts(echo if scene.phase_sign > 0 else echo.conj(), part)
            volts[channel] = clean + mixer.amplitude_v * scene.noise.made(rng, count, converter.rate_hz)
            for one in scene.disturbances:
                volts[channel] = one.volts(channel, time_s, volts[channel], mixer.amplitude_v)
    codes = converter.codes(volts)
    for one in scene.disturbances:
        codes = one.codes(codes)
    digitisation = Digitisation(
        iq_names(len(codes) // 2),
        scene.setup.daq.rate_hz,
        ((0.0, converter.step_v),) * len(codes),
        converter.skew_s if scene.skew_in_file else None,
        device="simulated",
    )
    place = drop.position(converter.times_s(count, 0))
    times = np.array([impact.time_s for impact in drop.impacts])
    truth = Truth(place, scene.room.path_m(place), times)
    return Record(scene, Recording(scene.name, codes, digitisation), truth)
