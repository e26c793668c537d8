"""Disturbances that are functions of time, not of position: drift of the offset and mains pick-up."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.seeds import Stream, generator

_N_SLOW = 3
_SLOWEST_HZ, _FASTEST_HZ = 0.03, 0.3


class Disturbance:
    """What is added to one channel as time goes, in amplitudes.

    Drift: three slow sines (periods 3 to 30 s) of root mean square size / sqrt(2) in each channel, so that the offset
    of I and Q together moves by `drift`; anew for each run. Mains: a sine of up to `mains`, its share fixed for each
    channel, its phase anew for each run.
    """

    def __init__(self, simulation: Simulation, channel: int, run: int) -> None:
        slow = generator(simulation.seed, Stream.DRIFT, channel, run)
        self._drift = simulation.size("drift") / np.sqrt(_N_SLOW)
        self._drift_rad_s = 2.0 * np.pi * slow.uniform(_SLOWEST_HZ, _FASTEST_HZ, _N_SLOW)
        self._drift_rad = slow.uniform(0.0, 2.0 * np.pi, _N_SLOW)
        wiring = generator(simulation.seed, Stream.MAINS, channel)
        self._mains = simulation.size("mains") * wiring.uniform(0.5, 1.0)
        self._mains_rad_s = 2.0 * np.pi * simulation.mains_frequency_hz
        own_phase = wiring.uniform(-0.5, 0.5)
        self._mains_rad = own_phase + generator(simulation.seed, Stream.MAINS_PHASE, run).uniform(0.0, 2.0 * np.pi)

    def at(self, time_s: FloatArray) -> FloatArray | float:
        """Return what is added at times (n,), shape (n,); 0.0 where nothing is."""
        total: FloatArray | float = 0.0
        if self._drift:
            for rate, phase in zip(self._drift_rad_s, self._drift_rad, strict=True):
                total = total + self._drift * np.sin(rate * time_s + phase)
        if self._mains:
            total = total + self._mains * np.sin(self._mains_rad_s * time_s + self._mains_rad)
        return total
