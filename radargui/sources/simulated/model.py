"""The simulated sources: a radar while a sphere moves, and the operator of the wiring check."""

from abc import abstractmethod
from dataclasses import replace
from functools import lru_cache

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray, RawArray
from radargui.model.errors import SetupError, worded
from radargui.model.recording import Block, Digitisation, Gap, Truth
from radargui.model.setup import Setup
from radargui.model.wiring import wiring_steps
from radargui.physics.path_length import Antennas, path_lengths, place_antennas
from radargui.sources.contract import SYSTEM_CLOCK, Clock, PacedSource
from radargui.sources.simulated.noise import Converter, Disturbance, Flicker, TracerMismatch, WhiteNoise, make_mixer
from radargui.sources.simulated.scene import Scene, minimum_jerk
from radargui.sources.simulated.waves import Reflector, dot, make_waves, reflectors_of

CHUNK = 4096
"""Samples drawn and computed at a time, whatever is asked for: the same noise for any length of blocks."""


class SimulatedRadar:
    """Samples and truth of one simulated run at any index.

    Samples are computed in chunks of 4096 that begin at multiples of 4096, so that every sample is the same, bit for
    bit, however a run is read.

    Raises
    ------
    SetupError
        The simulated scene is impossible.
    """

    def __init__(self, setup: Setup, *, run: int = 0, repeat: bool = False) -> None:
        simulation = setup.simulation
        release = np.array(setup.tracer.release_position_m)
        self._antennas = place_antennas(setup)
        self.scene = Scene(setup, run=run, repeat=repeat)
        check_clearance(setup, self.scene, self._antennas, reflectors_of(setup))
        self._rate_hz = setup.daq.rate_hz
        self._skew_s = setup.daq.channel_skew_s
        self._sign = setup.radar.phase_sign
        self._amplitude_v = simulation.amplitude_v
        self._crosstalk = simulation.crosstalk
        self._waves = make_waves(setup, self._antennas).along(places_of(self.scene))
        self._mixers = [make_mixer(simulation, receiver) for receiver in range(setup.n_receivers)]
        self._tracer = [TracerMismatch(simulation, receiver, release) for receiver in range(setup.n_receivers)]
        self._disturbance = [Disturbance(simulation, channel, run) for channel in range(2 * setup.n_receivers)]
        self._noises: list[WhiteNoise | Flicker] = [WhiteNoise(simulation, run)]
        if simulation.flicker:
            self._noises.append(Flicker(simulation, setup.daq.rate_hz, 2 * setup.n_receivers, run, CHUNK))
        self._converter = Converter(simulation, setup.daq)
        self.digitisation = Digitisation(
            channel_names=setup.channel_names,
            sample_rate_hz=setup.daq.rate_hz,
            scaling=self._converter.scaling(2 * setup.n_receivers),
            channel_skew_s=setup.daq.channel_skew_s,
            device="simulated",
        )
        duration_s = self.scene.duration_s
        self.n_samples = None if duration_s is None else max(round(duration_s * self._rate_hz), 1)
        # several blocks lie in a chunk: the last one made is kept
        self._chunk = lru_cache(maxsize=1)(self._new_chunk)

    def samples(self, first: int, count: int) -> RawArray:
        """Return samples first : first + count of all channels, shape (n_channels, count), a new array."""
        chunks = range(first // CHUNK, (first + count - 1) // CHUNK + 1)
        whole: RawArray = np.concatenate([self._chunk(chunk) for chunk in chunks], axis=1)
        begin = first - chunks.start * CHUNK
        return whole[:, begin : begin + count].copy()

    def truth(self, first: int, count: int) -> Truth:
        """Return the exact motion during samples first : first + count, impacts counted from sample first."""
        first_s = first / self._rate_hz
        position = self.scene.position_m(np.arange(first, first + count) / self._rate_hz)
        # counted from the first sample asked for, as a run file counts
        impacts = self.scene.impacts_s(first_s, (first + count) / self._rate_hz) - first_s
        return Truth(position, path_lengths(position, self._antennas), impacts)

    def _new_chunk(self, chunk: int) -> RawArray:
        volts = self._volts(np.arange(chunk * CHUNK, (chunk + 1) * CHUNK) / self._rate_hz)
        for noise in self._noises:
            noise.add_to(volts, chunk)
        return self._converter.convert(volts)

    def _volts(self, time_s: FloatArray) -> FloatArray:
        """Return the noiseless volts of all channels, shape (n_channels, n), at the times (n,) of channel 0.

        The multiplexer leaves a share of the channel before in each: v + crosstalk (v_before - v); before channel 0
        came the last one of the scan before.
        """
        if self._crosstalk:
            time_s = np.concatenate([time_s[:1] - 1.0 / self._rate_hz, time_s])
        volts = np.empty((self.digitisation.n_channels, time_s.size))
        position = self._places(time_s)
        field = self._waves.at_tracer(position)
        signal: ComplexArray | None = None
        for channel in range(self.digitisation.n_channels):
            receiver, is_q = divmod(channel, 2)
            own_time_s = time_s
            # the multiplexer comes to this channel later: the sphere has moved on meanwhile
            if self._skew_s and channel:
                own_time_s = time_s + channel * self._skew_s
                position = self._places(own_time_s)
                field = self._waves.at_tracer(position)
            if self._skew_s or not is_q or signal is None:
                signal = self._tracer[receiver].applied(self._waves.received(receiver, position, field), position)
                # Q inverted by the wiring: the phase runs the other way
                if self._sign < 0:
                    signal = signal.conj()
            mixer = self._mixers[receiver]
            clean = mixer.q(signal) if is_q else mixer.i(signal)
            volts[channel] = self._amplitude_v * (clean + self._disturbance[channel].at(own_time_s))
        if not self._crosstalk:
            return volts
        # charge of the channel converted just before; of the first one the last of the scan before
        before = np.concatenate([volts[-1:, :-1], volts[:-1, 1:]])
        return np.asarray(volts[:, 1:] + self._crosstalk * (before - volts[:, 1:]))

    def _places(self, time_s: FloatArray) -> FloatArray:
        """Return the positions (3, n), or (3, 1) where the sphere rests all the time: everything is computed once."""
        position = self.scene.position_m(time_s)
        return position[:, :1] if (position == position[:, :1]).all() else position


_N_PLACES = 2001
"""Places along the motion that are looked at. Chosen by hand."""
_CLEARANCE_M = 0.02
"""Room that an antenna takes around its place. Chosen by hand."""


def places_of(scene: Scene) -> FloatArray:
    """Return places all along a motion, the lowest among them, shape (3, n)."""
    motion = scene.trajectory
    times = np.concatenate([np.linspace(0.0, motion.duration_s, _N_PLACES), motion.impact_time_s])
    return motion.position_m(times)


def check_clearance(setup: Setup, scene: Scene, antennas: Antennas, reflectors: tuple[Reflector, ...]) -> None:
    """Check the whole way of the sphere.

    Raises
    ------
    SetupError
        It comes within 2 cm of an antenna, or passes a reflector.
    """
    # all along: a motion that begins and ends in the clear may pass an antenna
    position = places_of(scene)
    names = ["transmitter", *(f"receiver {number}" for number in range(1, antennas.n_receivers + 1))]
    for name, place in zip(names, [antennas.transmitter_m, *antennas.receivers_m], strict=True):
        away = position - place[:, None]
        if float(dot(away, away).min()) < (_CLEARANCE_M + 0.5 * setup.tracer.diameter_m) ** 2:
            raise worded(SetupError, "hits_antenna", name=name)
    for reflector in reflectors:
        if float(reflector.height_m(position).min()) >= 0.0:
            continue
        if reflector.wall is None:
            raise worded(SetupError, "passes_bottom")
        raise worded(SetupError, "passes_wall", number=reflector.wall + 1)


class ComputedSource(PacedSource):
    """Samples that are computed when their time has come; `_digitisation` says how they are digitised."""

    _digitisation: Digitisation

    def open(self) -> Digitisation:
        """Return how samples are digitised."""
        self._opened = True
        return self._digitisation

    def _read(self) -> Block | None:
        first, end = self._next, self._end_of_block()
        if end <= first or not self._wait_for(end):
            return None
        self._next = end
        return Block(self._samples(first, end), first)

    @abstractmethod
    def _samples(self, first: int, end: int) -> RawArray:
        """Return samples first:end of all channels, a new array."""


class SimulatedSource(ComputedSource):
    """One simulated run, or one that repeats for ever.

    In real time it behaves like a device: a reader that is more than `daq.buffer_s` late loses the oldest samples
    and is reported so by the gap of the next block.

    Parameters
    ----------
    setup
        `[simulation]` says what happens, `[daq]` how it is sampled.
    run
        Number of the run in its session: noise, drift and mains differ, hardware and surroundings stay.
    realtime
        Give out samples when their time has come; otherwise as fast as asked.
    clock
        Paces real time.
    repeat
        Carry the sphere back to the release and let it go again, for ever.

    Raises
    ------
    SetupError
        The simulated scene is impossible.
    """

    def __init__(
        self, setup: Setup, *, run: int = 0, realtime: bool = False, clock: Clock = SYSTEM_CLOCK, repeat: bool = False
    ) -> None:
        self._radar, daq = SimulatedRadar(setup, run=run, repeat=repeat), setup.daq
        super().__init__(
            "The simulated source", clock, daq.rate_hz, daq.read_interval_s, self._radar.n_samples, realtime=realtime
        )
        self._buffer = max(round(daq.buffer_s * daq.rate_hz), self._block)
        self._digitisation = self._radar.digitisation

    def _read(self) -> Block | None:
        gap = self._overflow()
        block = super()._read()
        return None if block is None else replace(block, gap=gap)

    def _samples(self, first: int, end: int) -> RawArray:
        return self._radar.samples(first, end - first)

    def truth(self, first_index: int, count: int) -> Truth:
        """Return the exact motion during samples first_index : first_index + count.

        Impact times count from sample `first_index`.
        """
        return self._radar.truth(first_index, count)

    def _overflow(self) -> Gap | None:
        # as the ring of a driver: what was not read in time is overwritten, the oldest first
        lost = self.backlog() - self._buffer
        if lost <= 0:
            return None
        gap = Gap(self._next, lost, "the buffer overflowed: samples were not read in time")
        self._next += lost
        return gap


AWAY_M = 0.15
"""How far the simulated operator lowers the sphere where the path shall grow."""
_HAND_M, _SWING_M, _SWING_HZ = 0.20, 0.03, 1.3
"""Distance of the waving hand from an antenna, and its swing: four fringes there and back."""
_OWN, _OTHERS = 0.8, 0.1
"""Echo of the hand in the antenna it is in front of, and in the others, relative to the tracer's."""


class WiringScene(ComputedSource):
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
        names = setup.channel_names
        scaling = self._converter.scaling(len(names))
        self._digitisation = Digitisation(names, self._rate_hz, scaling, 0.0, device="simulated operator")

    def _samples(self, first: int, end: int) -> RawArray:
        volts = self._volts(np.arange(first, end) / self._rate_hz)
        self._noise.add_to(volts, first // self._block)
        return self._converter.convert(volts)

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
