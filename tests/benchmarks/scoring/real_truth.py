"""The real recordings of others and what is known of them, found without the program (README of the test data)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from benchmarks.world.one_receiver.scene import runs
from scipy import io, ndimage, signal

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.recording import Digitisation, Recording, iq_names

KLC6_HZ = 24.13e9
"""K-LC6 radar of the 24 GHz recordings."""
PLATE_WAVELENGTH_M = 33.31e-3
JUNK_SAMPLES = 300
VOLTS_PER_CODE = 3.3 / 4096
IN_BEAM_V = 0.010
"""DIA: rms over 0.2 s above which the echo stands 11 dB over the noise of 2.7 mV."""
OUT_OF_BEAM_V = 0.0033
"""DIA: rms below which what is left of the echo is less than the noise."""
LEVEL_S = 0.2
WINDOW_S, HOP_S = 0.25, 0.05
CONTRAST_DB, ONE_SIDED_DB = 30.0, 12.0
"""A line of a spectrum is a target where it stands so far over the median, and over its own image: hum has none."""
STEADY_SHARE = 0.1


@dataclass(frozen=True, slots=True)
class Source:
    """Where a recording is and how its truth is found.

    Attributes
    ----------
    file
        Below the folder of the test data; for 9 GHz the stem.
    columns
        Of I and Q.
    phase_sign, frequency_hz
        For the setup.
    truth
        phase: band-passed, moment-corrected phase. line: the strongest one-sided line of a 0.25 s spectrum. plate:
        plain arctangent. beam: the same where the echo is there. still: nothing moves.
    band_hz
        Where the Doppler lies.
    begin_s
        Nothing is judged before.
    speed_m_s
        As the README gives it, absolute; None where it gives none.
    gain_ratio, quadrature_error_deg
        As the README gives them, the latter absolute; with its uncertainties (0.004, 0.4 deg).
    """

    file: str
    columns: tuple[int, int] = (0, 1)
    phase_sign: int = 1
    frequency_hz: float = KLC6_HZ
    truth: str = "line"
    band_hz: tuple[float, float] = (20.0, 1000.0)
    begin_s: float = 0.0
    speed_m_s: float | None = None
    gain_ratio: float | None = None
    quadrature_error_deg: float | None = None


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of a recording, each of shape (n_samples,): path where judged, and where the echo is absent."""

    path_m: FloatArray
    judged: BoolArray
    absent: BoolArray


def _car(run: str, speed_m_s: float) -> Source:
    return Source(
        f"radar-24ghz/car_{run}.bin", (1, 0), 1, KLC6_HZ, "phase", (100.0, 600.0), 0.0, speed_m_s, 0.762, 25.3
    )


def _fort(run: str, speed_m_s: float) -> Source:
    file = f"radar-24ghz/fram_fort_{run}.bin"
    return Source(file, (0, 4), -1, KLC6_HZ, "phase", (40.0, 180.0), 0.0, speed_m_s, 1.02, 17.5)


_PLATE_HZ = 299_792_458.0 / PLATE_WAVELENGTH_M
SOURCES: dict[str, Source] = {
    "car_veryslow2": _car("veryslow2", 1.32),
    "car_slow5": _car("slow5", 1.7),
    "car_rev2": _car("rev2", 1.8),
    "fram_fort_1": _fort("1", 0.540),
    "fram_fort_2": _fort("2", 0.534),
    "mains_02": Source("radar-24ghz/mains_02.bin", band_hz=(110.0, 600.0), speed_m_s=1.339),
    "mains_12": Source("radar-24ghz/mains_12.bin", band_hz=(110.0, 600.0), speed_m_s=2.761),
    "walk_4fwd": Source("radar-24ghz/walk_4fwd.bin", band_hz=(30.0, 800.0), begin_s=0.45, speed_m_s=0.871),
    "radarSample": Source("radar-24ghz/radarSample.dat", band_hz=(20.0, 3000.0)),
    "PRG": Source("radar-9ghz/TB2_PRG_9", frequency_hz=_PLATE_HZ, truth="plate", speed_m_s=0.299),
    "DIA": Source("radar-9ghz/TB2_PRG_9_DIA", frequency_hz=_PLATE_HZ, truth="beam", speed_m_s=0.1005),
    "ruido": Source("radar-9ghz/TB2_ruido", frequency_hz=_PLATE_HZ, truth="still"),
}


def read(folder: Path, name: str) -> Recording:
    """Return a recording of the test data as volts."""
    source = SOURCES[name]
    if source.file.startswith("radar-24ghz"):
        data = (folder / source.file).read_bytes()
        period_us = float(np.frombuffer(data[:8], "<f8")[0])
        columns = np.frombuffer(data[8:], "<u2").reshape(-1, 5)[JUNK_SAMPLES:, source.columns]
        return _recording(name, columns.T * VOLTS_PER_CODE, 1e6 / period_us)
    parts = [io.loadmat(folder / f"{source.file}_{part}_C.mat", squeeze_me=True)["src1"] for part in "IQ"]
    rate_hz = float(parts[0]["SampleFrequency"])
    return _recording(name, np.array([np.asarray(part["Data"].item(), dtype=float) for part in parts]), rate_hz)


def _recording(name: str, volts: FloatArray, rate_hz: float) -> Recording:
    return Recording(name, np.ascontiguousarray(volts), Digitisation(iq_names(1), rate_hz))


def known_of(name: str, recording: Recording, wavelength_m: float) -> Known:
    """Return what is known of a recording."""
    source = SOURCES[name]
    volts, rate_hz = recording.volts(), recording.digitisation.sample_rate_hz
    nothing = np.zeros(volts.shape[1], dtype=np.bool_)
    if source.truth == "still":
        return Known(np.zeros(volts.shape[1]), ~nothing, nothing)
    if source.truth == "phase":
        turns, judged = _band_passed(volts, rate_hz, source.band_hz)
    elif source.truth == "line":
        turns, judged = _lines(volts, rate_hz, source.band_hz)
    else:
        centre_v = np.array([0.085, -0.486]) if source.truth == "plate" else np.median(volts, axis=1)
        wave = (volts[0] - centre_v[0]) + 1j * (volts[1] - centre_v[1])
        turns, judged = np.unwrap(np.angle(wave)) / (2.0 * np.pi), ~nothing
        if source.truth == "beam":
            level_v = np.sqrt(ndimage.uniform_filter1d(np.abs(wave) ** 2, round(LEVEL_S * rate_hz)))
            judged, nothing = level_v >= IN_BEAM_V, level_v < OUT_OF_BEAM_V
    judged = judged & (np.arange(len(judged)) >= source.begin_s * rate_hz)
    return Known(source.phase_sign * wavelength_m * turns, judged, nothing)


def moments_of(volts: FloatArray) -> tuple[float, float]:
    """Return gain ratio and quadrature error in deg from second moments of I and Q, shape (2, n_samples)."""
    covariance = np.cov(volts)
    gain_ratio = np.sqrt(covariance[1, 1] / covariance[0, 0])
    sine = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    return float(gain_ratio), float(np.rad2deg(np.arcsin(sine)))


def corrected(volts: FloatArray, gain_ratio: float, quadrature_error_deg: float) -> np.ndarray:
    """Return i + jq of I = i, Q = g (q cos e + i sin e), shape (n_samples,)."""
    error = np.deg2rad(quadrature_error_deg)
    quadrature = (volts[1] / gain_ratio - volts[0] * np.sin(error)) / np.cos(error)
    return np.asarray(volts[0] + 1j * quadrature)


def band_passed(volts: FloatArray, rate_hz: float, band_hz: tuple[float, float]) -> FloatArray:
    """Return I and Q within a band, no phase turned, shape (2, n_samples)."""
    filtering = signal.butter(4, band_hz, "bandpass", fs=rate_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(filtering, volts, axis=1))


def _band_passed(volts: FloatArray, rate_hz: float, band_hz: tuple[float, float]) -> tuple[FloatArray, BoolArray]:
    inside = band_passed(volts, rate_hz, band_hz)
    wave = corrected(inside, *moments_of(inside))
    size = np.sqrt(ndimage.uniform_filter1d(np.abs(wave) ** 2, round(0.02 * rate_hz)))
    judged = size >= 0.3 * np.sqrt(np.mean(size**2))
    edge = round(0.02 * rate_hz)  # the filter sets in and ends
    judged[:edge] = judged[-edge:] = False
    return np.unwrap(np.angle(wave)) / (2.0 * np.pi), judged


def _lines(volts: FloatArray, rate_hz: float, band_hz: tuple[float, float]) -> tuple[FloatArray, BoolArray]:
    window, hop, n_samples = round(WINDOW_S * rate_hz), round(HOP_S * rate_hz), volts.shape[1]
    frequency_hz = np.fft.fftfreq(4 * window, 1.0 / rate_hz)
    inside = np.flatnonzero((np.abs(frequency_hz) > band_hz[0]) & (np.abs(frequency_hz) < band_hz[1]))
    middles, lines, clear = [], [], []
    for first in range(0, n_samples - window + 1, hop):
        part = volts[:, first : first + window]
        wave = (part[0] - part[0].mean()) + 1j * (part[1] - part[1].mean())
        power = np.abs(np.fft.fft(wave * np.hanning(window), 4 * window)) ** 2
        best = int(inside[power[inside].argmax()])
        one_sided = power[best] >= 10 ** (ONE_SIDED_DB / 10.0) * power[-best]
        contrast = power[best] >= 10 ** (CONTRAST_DB / 10.0) * np.median(power[inside])
        middles.append(first + window / 2)
        lines.append(float(frequency_hz[best]))
        clear.append(bool(one_sided and contrast))
    line_hz, good = np.array(lines), np.array(clear)
    steady = np.abs(np.diff(line_hz)) <= STEADY_SHARE * np.abs(line_hz[:-1])
    linked = good[:-1] & good[1:] & steady
    judged = np.zeros(n_samples, dtype=np.bool_)
    for first, last in runs(linked):
        judged[round(middles[first]) : round(middles[last])] = True
    return np.cumsum(np.interp(np.arange(n_samples), middles, line_hz)) / rate_hz, judged
