"""White noise, drawn chunk by chunk so that it does not depend on how a run is read."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.seeds import Stream, generator


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
            volts += self.sigma_v * generator(self._seed, Stream.NOISE, self._run, chunk).standard_normal(volts.shape)
