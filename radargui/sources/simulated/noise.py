"""Simulate what time adds to a channel: white and 1/f noise, drift and hum, the same however a run is read.

Simulate the mismatch: mixers and converter, constant for a session, and what changes with the tracer.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray, RawArray
from radargui.model.daq import Daq
from radargui.model.front_end import channels_of
from radargui.model.simulation import Simulation


class Draw(IntEnum):
    """Parts that draw random numbers; switching one off leaves the others as they are."""

    HARDWARE = 1
    BIAS = 2
    AMPLITUDE = 3
    DRIFT = 4
    REFLECTION = 5
    MAINS = 6
    NOISE = 7
    MAINS_PHASE = 8
    FLICKER = 9
    FLICKER_ANCHORS = 10
    WALL = 11
    KICK = 12
    RESTITUTION = 13


def generator(seed: int, purpose: Draw, *key: int) -> np.random.Generator:
    """Return the generator of a part; `key` tells run, receiver or chunk."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(purpose), *key)))


_N_SLOW = 3  # sines of the drift (chosen by hand: one would repeat itself)
_SLOWEST_HZ, _FASTEST_HZ = 0.03, 0.3
"""Periods of 3 to 30 s: the drift of warming electronics is slower than a fall."""


class Disturbance:
    """What is added to one channel as time goes, in amplitudes.

    Drift: three slow sines (periods 3 to 30 s) of root mean square size / sqrt(2) in each channel, so that the offset
    of I and Q together moves by `drift`; anew for each run. Mains: a sine of up to `mains`, its share fixed for each
    channel, its phase anew for each run.
    """

    def __init__(self, simulation: Simulation, channel: int, run: int) -> None:
        slow = generator(simulation.seed, Draw.DRIFT, channel, run)
        # of I and Q each 1 / sqrt(2): together they move by `drift`
        self._drift = simulation.size("drift") / np.sqrt(_N_SLOW)
        self._drift_rad_s = 2.0 * np.pi * slow.uniform(_SLOWEST_HZ, _FASTEST_HZ, _N_SLOW)
        self._drift_rad = slow.uniform(0.0, 2.0 * np.pi, _N_SLOW)
        wiring = generator(simulation.seed, Draw.MAINS, channel)
        self._mains = simulation.size("mains") * wiring.uniform(0.5, 1.0)
        self._mains_rad_s = 2.0 * np.pi * simulation.mains_frequency_hz
        # nearly in phase on all channels: one loop of the wiring picks the hum up
        own_phase = wiring.uniform(-0.5, 0.5)
        self._mains_rad = own_phase + generator(simulation.seed, Draw.MAINS_PHASE, run).uniform(0.0, 2.0 * np.pi)

    def at(self, time_s: FloatArray) -> FloatArray | float:
        """Return what is added at times (n,), shape (n,); 0.0 where nothing is."""
        total: FloatArray | float = 0.0
        if self._drift:
            for rate, phase in zip(self._drift_rad_s, self._drift_rad, strict=True):
                total = total + self._drift * np.sin(rate * time_s + phase)
        if self._mains:
            total = total + self._mains * np.sin(self._mains_rad_s * time_s + self._mains_rad)
        return total


class WhiteNoise:
    """Independent normal noise of all channels.

    sigma = amplitude / sqrt(2) 10^(-SNR / 20), from SNR = 10 log10(A^2 / (2 sigma^2)), sigma of one channel.
    """

    def __init__(self, simulation: Simulation, run: int) -> None:
        self._seed = simulation.seed
        self._run = run
        sigma_v = simulation.amplitude_v / np.sqrt(2.0) * 10.0 ** (-simulation.snr_db / 20.0)
        self.sigma_v = sigma_v if simulation.noise else 0.0

    def add_to(self, volts: FloatArray, chunk: int) -> None:
        """Add the noise of a chunk to its volts (n_channels, n)."""
        if self.sigma_v:
            volts += self.sigma_v * generator(self._seed, Draw.NOISE, self._run, chunk).standard_normal(volts.shape)


_BLOCK = 256  # chunks drawn at a time; another number draws other noise from a seed (chosen by hand)


class Anchors:
    """Ornstein-Uhlenbeck processes of variance 1, sampled once a chunk: x -> d x + sqrt(1 - d^2) w, d = exp(-loss).

    They are drawn in blocks of 256 chunks, always from the first: the same states whatever is asked for and when. A
    skip costs some microseconds a chunk skipped, going back begins again.

    Parameters
    ----------
    seed, run
        Draw the states.
    loss
        Logarithm of the decay over a chunk, shape (n_processes,).
    n_channels
        Independent processes of each kind.
    """

    def __init__(self, seed: int, run: int, loss: FloatArray, n_channels: int) -> None:
        self._seed, self._run = seed, run
        # expm1 below: 1 - d^2 of a process slower than the chunk is lost in the rounding of 1
        self._decay = np.exp(-loss)[:, None]
        self._kick = np.sqrt(-np.expm1(-2.0 * loss))[:, None]
        self._shape = (loss.size, n_channels)
        self._block = 0
        self._states = self._begun()

    def around(self, chunk: int) -> tuple[FloatArray, FloatArray]:
        """Return the states at the first sample of a chunk and of the next, shape (n_processes, n_channels) each."""
        block, offset = divmod(chunk, _BLOCK)
        if block < self._block:
            self._block, self._states = 0, self._begun()
        while self._block < block:
            self._block += 1
            self._states = self._continued(self._states[-1], self._block)
        return self._states[offset], self._states[offset + 1]

    def _begun(self) -> FloatArray:
        start = generator(self._seed, Draw.FLICKER_ANCHORS, self._run).standard_normal(self._shape)
        return self._continued(start, 0)

    def _continued(self, state: FloatArray, block: int) -> FloatArray:
        """Return the states of a block and the first of the next, shape (257, n_processes, n_channels)."""
        kicks = generator(self._seed, Draw.FLICKER_ANCHORS, self._run, block).standard_normal((_BLOCK, *self._shape))
        states = np.empty((_BLOCK + 1, *self._shape))
        states[0] = state
        for step, kick in enumerate(kicks):
            states[step + 1] = self._decay * states[step] + self._kick * kick
        return states


LOWEST_HZ, HIGHEST_HZ = 0.1, 1000.0
"""Band of `Flicker`: from slower than a fall to faster than its Doppler. Chosen by hand."""
CORNERS_HZ = np.geomspace(0.01, 10_000.0, 9)
"""A decade beyond the band on either side; nine are enough for 1/f within 3 % (see `Flicker`)."""


class Flicker:
    """Independent 1/f noise of all channels.

    Each channel gets the sum of nine Ornstein-Uhlenbeck processes of equal variance s^2 with corner frequencies f_c
    from 0.01 Hz to 10 kHz, evenly spread in log f. Its one-sided spectral density,
    sum 2 s^2 / (pi f_c (1 + (f / f_c)^2)), is C / f within 3 % from 0.1 Hz to 1 kHz (van der Ziel 1950: a spread of
    relaxation times gives 1/f). s is such that the root mean square in this band is `flicker` amplitudes; a decade
    then holds half of that. Below and above the band it goes on for a decade: a run also has an offset of this size,
    and at a low rate the converter folds the fast part down, as one without a filter does.

    The states at the edges of the chunks are an exact autoregression (see `Anchors`), inside a chunk each process
    is drawn free and then bent to meet the next state: the exact distribution of a bridge (conditioning by kriging).

    Parameters
    ----------
    simulation
        Its `flicker`, `amplitude_v` and `seed`.
    rate_hz
        Samples per second and channel.
    n_channels
        Number of channels.
    run
        Each run has its own noise.
    chunk_length
        Samples of a chunk.
    """

    def __init__(self, simulation: Simulation, rate_hz: float, n_channels: int, run: int, chunk_length: int) -> None:
        self._seed, self._run = simulation.seed, run
        self._scale_v = simulation.amplitude_v * simulation.flicker * unit_scale()
        self._shape = (CORNERS_HZ.size, n_channels, chunk_length)
        # the decay over one sample is exp(-loss)
        # a process of corner f_c forgets with the time constant 1 / (2 pi f_c)
        self._loss = 2.0 * np.pi * CORNERS_HZ / rate_hz
        self._anchors = Anchors(simulation.seed, run, self._loss * chunk_length, n_channels)
        steps = np.arange(1, chunk_length + 1)
        loss = self._loss[:, None]
        self._decay = np.exp(-loss * steps)
        self._share = np.exp(-loss * (chunk_length - steps)) * np.expm1(-2.0 * loss * steps)
        self._share /= np.expm1(-2.0 * loss * chunk_length)

    def add_to(self, volts: FloatArray, chunk: int) -> None:
        """Add the noise of a chunk to its volts (n_channels, chunk_length)."""
        # most of a second to load, and few scenes flicker
        from scipy.signal import lfilter

        start, end = self._anchors.around(chunk)
        drawn = generator(self._seed, Draw.FLICKER, self._run, chunk).standard_normal(self._shape)
        total = np.zeros(self._shape[1:])
        for term, loss in enumerate(self._loss):
            kick = np.sqrt(-np.expm1(-2.0 * loss))
            free = lfilter([kick], [1.0, -np.exp(-loss)], drawn[term])
            decay, share = self._decay[term], self._share[term]
            # the free path ends anywhere: what is missing at the end is spread as its covariance with the end
            missed = end[term] - decay[-1] * start[term] - free[:, -1]
            total += free
            total += start[term][:, None] * decay
            total += missed[:, None] * share
        # steps run from 1: the last one is the first sample of the next chunk
        volts[:, 1:] += self._scale_v * total[:, :-1]
        volts[:, 0] += self._scale_v * start.sum(axis=0)


def unit_scale() -> float:
    """Return s of `Flicker` for root mean square 1 in its band: each density integrates to an arctangent."""
    inside = np.arctan(HIGHEST_HZ / CORNERS_HZ) - np.arctan(LOWEST_HZ / CORNERS_HZ)
    return float(1.0 / np.sqrt(2.0 / np.pi * inside.sum()))


_CODES = 32768
"""Codes of 16 bits on either side of zero."""


@dataclass(frozen=True, slots=True)
class Mixer:
    """One receiver's mixer: I = Re Z + offset_i, Q = gain (sin e Re Z + cos e Im Z) + offset_q.

    Attributes
    ----------
    gain
        Amplitude of Q over amplitude of I.
    quadrature_error_rad
        e.
    offset_i, offset_q
        In amplitudes.
    """

    gain: float = 1.0
    quadrature_error_rad: float = 0.0
    offset_i: float = 0.0
    offset_q: float = 0.0

    def i(self, signal: ComplexArray) -> FloatArray:
        """Return I of the complex signal (n,), in amplitudes."""
        return np.asarray(signal.real + self.offset_i)

    def q(self, signal: ComplexArray) -> FloatArray:
        """Return Q of the complex signal (n,), in amplitudes."""
        return np.asarray(channels_of(signal, signal, self.gain, self.quadrature_error_rad)[1] + self.offset_q)


def make_mixer(simulation: Simulation, receiver: int) -> Mixer:
    """Return the mixer of a receiver: the same for all runs with one seed, different for each receiver.

    The offset (I, Q) has the size of `dc_offset` and a random direction; the gain is 1 + or - 0.6 to 1 times
    `gain_error`; the quadrature error is + or - 0.6 to 1 times its size, or exactly `quadrature_error_deg` where
    that is set.
    """
    draw = generator(simulation.seed, Draw.HARDWARE, receiver)
    direction = draw.uniform(0.0, 2.0 * np.pi)
    # never near zero: every receiver has something to correct
    share = draw.choice([-1.0, 1.0], 2) * draw.uniform(0.6, 1.0, 2)
    error = share[1] * simulation.size("quadrature_error")
    if simulation.quadrature_error_deg is not None:
        error = np.radians(simulation.quadrature_error_deg)
    return Mixer(
        gain=1.0 + float(share[0] * simulation.size("gain_error")),
        quadrature_error_rad=float(error),
        offset_i=float(simulation.size("dc_offset") * np.cos(direction)),
        offset_q=float(simulation.size("dc_offset") * np.sin(direction)),
    )


class Converter:
    """An ADC of `adc_bits` bits over +-range_v, its codes left-justified in int16.

    code = step round(volts / (step lsb)), lsb = range_v / 32768, step = 2^(16 - bits); what lies outside gives the end
    codes -32768 and 32767. Zero bits: no converter at all, volts stay volts.
    """

    def __init__(self, simulation: Simulation, daq: Daq) -> None:
        self._bits = simulation.adc_bits
        self._lsb_v = daq.range_v / _CODES

    def scaling(self, n_channels: int) -> tuple[tuple[float, ...], ...] | None:
        """Return the coefficients of volts = sum c_k code^k of each channel; None for volts."""
        return ((0.0, self._lsb_v),) * n_channels if self._bits else None

    def convert(self, volts: FloatArray) -> RawArray:
        """Return samples (n_channels, n): int16 codes, or the volts themselves."""
        if not self._bits:
            return volts
        step = float(2 ** (16 - self._bits))
        # a coarser converter leaves the low bits zero: its codes are left-justified
        codes = np.rint(volts / (self._lsb_v * step)) * step
        # beyond the range a converter stays at its end codes: by them clipping is known
        return np.clip(codes, -_CODES, _CODES - 1).astype(np.int16)


LENGTH_M = 0.12
"""Over which what the tracer adds changes: some fringes, so that it varies over a fall."""
_N_WAVES = 4
"""Plane waves of random direction that make a smooth field. Chosen by hand."""


class SmoothField:
    """A random function of position with root mean square 1, real or complex.

    The sum of four cosines whose wave vectors have a normal distribution of standard deviation 1 / 0.12 m: a draw
    from a Gaussian process with the kernel exp(-d^2 / (2 (0.12 m)^2)) in random Fourier features (Rahimi & Recht
    2007). The complex field gives each cosine a random direction in the IQ plane.
    """

    def __init__(self, generator: np.random.Generator) -> None:
        self._wave_vector = generator.normal(0.0, 1.0 / LENGTH_M, (_N_WAVES, 3))
        self._phase = generator.uniform(0.0, 2.0 * np.pi, _N_WAVES)
        self._direction = np.exp(1j * generator.uniform(0.0, 2.0 * np.pi, _N_WAVES))

    def real_at(self, position_m: FloatArray) -> FloatArray:
        """Return the real field at positions (3, n), shape (n,)."""
        return np.asarray(self._waves(position_m).sum(axis=0))

    def complex_at(self, position_m: FloatArray) -> ComplexArray:
        """Return the complex field at positions (3, n), shape (n,)."""
        return np.asarray(self._direction @ self._waves(position_m))

    def _waves(self, position_m: FloatArray) -> FloatArray:
        """Return the cosines at positions (3, n), each of mean square 1 / 4: shape (4, n)."""
        phase = self._wave_vector @ position_m + self._phase[:, None]
        return np.asarray(np.sqrt(2.0 / _N_WAVES) * np.cos(phase))


class TracerMismatch:
    """Amplitude and offset of one receiver as functions of position, the same in all runs of a session.

    Z -> Z exp(v f(p)) + b F(p): f and F are smooth fields of root mean square 1, v and b the sizes of
    `amplitude_variation` and `bias`; f is counted from the release, where the amplitude stays as it is.
    """

    def __init__(self, simulation: Simulation, receiver: int, release_m: FloatArray) -> None:
        self._variation = simulation.size("amplitude_variation")
        self._bias = simulation.size("bias")
        self._amplitude_field = SmoothField(generator(simulation.seed, Draw.AMPLITUDE, receiver))
        self._bias_field = SmoothField(generator(simulation.seed, Draw.BIAS, receiver))
        # counted from there, so that `amplitude_v` is the amplitude at the release
        self._at_release = self._amplitude_field.real_at(release_m[:, None])

    def applied(self, signal: ComplexArray, position_m: FloatArray) -> ComplexArray:
        """Return the signal (n,) with the mismatch of positions (3, n); in amplitudes."""
        if self._variation:
            field = self._amplitude_field.real_at(position_m) - self._at_release
            # an exponential stays positive: a negative amplitude would turn the phase
            signal = signal * np.exp(self._variation * field)
        if self._bias:
            signal = signal + self._bias * self._bias_field.complex_at(position_m)
        return signal
