"""A scene: everything that makes one record, and the record with its truth."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from benchmarks.world.generic.mismatch import Field, Plane, reflections
from benchmarks.world.generic.motion import Motion
from numpy.typing import NDArray

from radargui.model.recording import Digitisation, Recording, Truth, iq_names
from radargui.model.setup import Setup

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Receiving:
    """One receiver's share: fields in amplitudes, gain Q/I, quadrature error, offsets in amplitudes."""

    amplitude: Field
    bias_i: Field
    bias_q: Field
    gain: float
    quadrature_rad: float
    offset: tuple[float, float]
    phase_rad: float


@dataclass(frozen=True)
class Scene:
    """One record to be made."""

    name: str
    kind: str
    setup: Setup
    motion: Motion
    receiving: tuple[Receiving, ...]
    amplitude_v: float
    snr_db: float
    rate_hz: float
    skew_s: float
    seed: int
    planes: tuple[Plane, ...] = ()
    flicker: float = 0.0
    mains: float = 0.0
    drag_1_m: float = 0.0
    range_v: float = 5.0
    facts: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class SceneRecord:
    """A made record: what an estimator may read, and the truth."""

    scene: Scene
    recording: Recording
    truth: Truth

    @property
    def setup(self) -> Setup:
        """The setup that the estimator gets."""
        return self.scene.setup


def places(setup: Setup) -> tuple[Array, Array]:
    """Return where the transmitter (3,) and the receivers (n_receivers, 3) of a setup stand."""
    tilt, azimuth = np.radians([(one.tilt_deg, one.azimuth_deg) for one in setup.receiver]).T
    outward = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)
    distances = np.array([one.distance_m for one in setup.receiver])
    return np.array([0.0, 0.0, setup.transmitter.distance_m]), distances[:, None] * outward


def paths(position_m: Array, setup: Setup) -> Array:
    """Return L_i = |p - tx| + |p - rx_i| of positions (3, n), shape (n_receivers, n)."""
    sender, receivers = places(setup)
    ranges = np.linalg.norm(position_m[None] - receivers[:, :, None], axis=1)
    return np.asarray(np.linalg.norm(position_m - sender[:, None], axis=0) + ranges)


def flicker_noise(rng: np.random.Generator, count: int, rate_hz: float) -> Array:
    """Return 1/f noise of unit rms from 0.5 Hz to 1 kHz, by shaping a spectrum."""
    frequency = np.fft.rfftfreq(count, 1.0 / rate_hz)
    shape = np.where((frequency >= 0.5) & (frequency < 1000.0), 1.0 / np.sqrt(np.maximum(frequency, 0.5)), 0.0)
    noise = np.fft.irfft(
        shape * (rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)), count
    )
    return noise / noise.std()


def make_record(scene: Scene) -> SceneRecord:
    """Make the record: I = Re Z + b_I, Q = g (sin eps Re Z + cos eps Im Z) + b_Q, noise, int16 codes."""
    rng = np.random.default_rng([scene.seed, 7])
    setup, motion = scene.setup, scene.motion
    sender, receivers = places(setup)
    wavenumber = 2.0 * np.pi / setup.radar.wavelength_m
    count = round(motion.duration_s * scene.rate_hz)
    time = np.arange(count) / scene.rate_hz
    release = np.asarray(setup.tracer.release_position_m)
    volts = np.empty((2 * setup.n_receivers, count))
    sigma = 10.0 ** (-scene.snr_db / 20.0) / np.sqrt(2.0)
    for receiver, own in enumerate(scene.receiving):
        for part in range(2):
            channel = 2 * receiver + part
            p = motion.position(time + channel * scene.skew_s)
            phase = setup.radar.phase_sign * (
                wavenumber * (paths(p, setup)[receiver] - paths(release[:, None], setup)[receiver]) + own.phase_rad
            )
            z = own.amplitude(p) * np.exp(1j * phase)
            images = reflections(p, sender, receivers[receiver], receiver, scene.planes, wavenumber)
            z = z * (images if setup.radar.phase_sign > 0 else images.conj())
            z = z + own.bias_i(p) + 1j * own.bias_q(p)
            if part == 0:
                signal = z.real
            else:
                signal = own.gain * (np.sin(own.quadrature_rad) * z.real + np.cos(own.quadrature_rad) * z.imag)
            signal = signal + own.offset[part] + sigma * rng.standard_normal(count)
            if scene.flicker > 0.0:
                signal += scene.flicker * flicker_noise(rng, count, scene.rate_hz)
            if scene.mains > 0.0:
                signal += scene.mains * np.sin(2.0 * np.pi * 50.0 * time + rng.uniform(0.0, 6.28))
            volts[channel] = scene.amplitude_v * signal
    step = scene.range_v / 32768.0
    raw = np.clip(np.round(volts / step), -32768, 32767).astype(np.int16)
    digitisation = Digitisation(
        iq_names(setup.n_receivers), scene.rate_hz, ((0.0, step),) * volts.shape[0], scene.skew_s, device="simulated"
    )
    p = motion.position(time)
    truth = Truth(p, paths(p, setup), np.array([impact.time_s for impact in motion.impacts]))
    return SceneRecord(scene, Recording(scene.name, raw, digitisation), truth)
