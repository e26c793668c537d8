"""The simulated source of the wiring check: an operator who does at once what the guide says."""

import numpy as np

from radargui.geometry.antennas import place_antennas
from radargui.geometry.path_length import path_lengths
from radargui.model.arrays import FloatArray
from radargui.model.block import Block
from radargui.model.digitisation import Digitisation
from radargui.model.setup import Setup
from radargui.model.wiring import wiring_steps
from radargui.sources.contract import SYSTEM_CLOCK, Clock
from radargui.sources.paced import PacedSource
from radargui.sources.simulated.mismatch import Converter
from radargui.sources.simulated.noise import WhiteNoise
from radargui.sources.simulated.scene import minimum_jerk

AWAY_M = 0.15
"""How far the simulated operator lowers the sphere where the path shall grow."""
_HAND_M, _SWING_M, _SWING_HZ = 0.20, 0.03, 1.3
"""Distance of the waving hand from an antenna, and its swing: four fringes there and back."""
_OWN, _OTHERS = 0.8, 0.1
"""Echo of the hand in the antenna it is in front of, and in the others, relative to the tracer's."""


class WiringScene(PacedSource):
    """Tracer at rest, lowered by 15 cm, then a hand that swings in front of each receiver in turn; then the end.

    Parameters
    ----------
    setup
        Antennas, release, amplitude, noise and converter.
    realtime
        Give out samples when their time has come.
    clock
        Paces real time.
    """

    def __init__(self, setup: Setup, *, realtime: bool = True, clock: Clock = SYSTEM_CLOCK) -> None:
        self._steps, daq = wiring_steps(setup.n_receivers), setup.daq
        n_samples = round((self._steps[-1].end_s + 0.5) * daq.rate_hz)
        super().__init__(
            "The simulated operator", clock, daq.rate_hz, daq.read_interval_s, n_samples, realtime=realtime
        )
        self._setup = setup
        self._antennas = place_antennas(setup)
        self._noise = WhiteNoise(setup.simulation, 0)
        self._converter = Converter(setup.simulation, setup.daq)

    def open(self) -> Digitisation:
        """Return how samples are digitised."""
        self._opened = True
        names = self._setup.channel_names
        scaling = self._converter.scaling(len(names))
        return Digitisation(names, self._rate_hz, scaling, 0.0, device="simulated operator")

    def _read(self) -> Block | None:
        first, end = self._next, self._end_of_block()
        if end <= first or not self._wait_for(end):
            return None
        self._next = end
        volts = self._volts(np.arange(first, end) / self._rate_hz)
        self._noise.add_to(volts, first // self._block)
        return Block(self._converter.convert(volts), first)

    def _volts(self, time_s: FloatArray) -> FloatArray:
        """Return I = A cos, Q = A sin of the tracer's phase, and the hand's on top; shape (n_channels, n)."""
        setup, wave_number = self._setup, 2.0 * np.pi / self._setup.radar.wavelength_m
        signal = np.exp(1j * wave_number * path_lengths(self._places(time_s), self._antennas))
        for step in self._steps:
            if step.receiver is None:
                continue
            inside = (time_s >= step.start_s) & (time_s < step.end_s)
            # there and back at the antenna itself: a phase of 2 k d
            hand_m = _HAND_M + _SWING_M * np.sin(2.0 * np.pi * _SWING_HZ * (time_s - step.start_s))
            # less the hand at its place: nothing jumps when it begins or ends
            echo = np.where(inside, np.exp(2j * wave_number * hand_m) - np.exp(2j * wave_number * _HAND_M), 0.0)
            strength = np.full(setup.n_receivers, _OTHERS)
            strength[step.receiver] = _OWN
            signal += strength[:, None] * echo
        if setup.radar.phase_sign < 0:
            signal = signal.conj()
        volts = np.empty((2 * setup.n_receivers, time_s.size))
        volts[0::2], volts[1::2] = signal.real, signal.imag
        return np.asarray(setup.simulation.amplitude_v * volts)

    def _places(self, time_s: FloatArray) -> FloatArray:
        """Return the tracer's position, shape (3, n): away from the antennas is down."""
        (away,) = (step for step in self._steps if step.kind == "away")
        share = np.clip((time_s - away.start_s) / (away.end_s - away.start_s), 0.0, 1.0)
        position = np.tile(np.array(self._setup.tracer.release_position_m)[:, None], (1, time_s.size))
        # down is away from the transmitter above and, at tilts below 90 degrees, from every receiver
        position[2] -= AWAY_M * minimum_jerk(share)
        return position
