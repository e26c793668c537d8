"""What time adds to a channel: white noise, drift of the offset, mains pick-up; the same however a run is read."""

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.seeds import Draw, generator

_N_SLOW = 3
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
        self._drift = simulation.size("drift") / np.sqrt(_N_SLOW)
        self._drift_rad_s = 2.0 * np.pi * slow.uniform(_SLOWEST_HZ, _FASTEST_HZ, _N_SLOW)
        self._drift_rad = slow.uniform(0.0, 2.0 * np.pi, _N_SLOW)
        wiring = generator(simulation.seed, Draw.MAINS, channel)
        self._mains = simulation.size("mains") * wiring.uniform(0.5, 1.0)
        self._mains_rad_s = 2.0 * np.pi * simulation.mains_frequency_hz
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
        self.sigma_v = simulation.amplitude_v / np.sqrt(2.0) * 10.0 ** (-simulation.snr_db / 20.0)
        if not simulation.noise:
            self.sigma_v = 0.0

    def add_to(self, volts: FloatArray, chunk: int) -> None:
        """Add the noise of a chunk to its volts (n_channels, n)."""
        if self.sigma_v:
            volts += self.sigma_v * generator(self._seed, Draw.NOISE, self._run, chunk).standard_normal(volts.shape)
