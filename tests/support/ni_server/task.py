"""An analogue input task of the stand-in driver, with the states and refusals of the real one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from support.ni_server.devices import CONFIGURATIONS, REFERENCE, START, StandInDevice
from support.ni_server.edges import AnalogEdge, DigitalEdge, Trigger
from support.ni_server.faults import NiError
from support.ni_server.meter import Meter
from support.ni_server.pace import Pace
from support.ni_server.precomputed import Precomputed
from support.ni_server.signal import Signal

TIMEOUT, OVERWRITTEN, NO_SUCH_TERMINAL = -200284, -200279, -89136


@dataclass(frozen=True)
class Channel:
    """One virtual channel."""

    name: str
    device: StandInDevice
    index: int
    low_v: float
    high_v: float


class StandInTask:
    """One task; the caller holds the pace's condition."""

    def __init__(
        self, name: str, signal: Signal, pace: Pace, meter: Meter | None = None, made: Precomputed | None = None
    ) -> None:
        self.name = name
        self._meter = meter or Meter()
        self._made = made
        self.channels: list[Channel] = []
        self.committed = False
        self.running = False
        self.rate_hz = 1000.0
        self.buffer = 1000
        self.convert_hz: float | None = None
        self._total: int | None = None
        self._trigger: Trigger | None = None
        self._signal = signal
        self._pace = pace
        self._mark = 0.0
        self._position = 0
        self._broken = 0

    @property
    def device(self) -> StandInDevice:
        """The device of the task."""
        if not self.channels:
            raise NiError(-200478)
        return self.channels[0].device

    def add_channel(self, device: StandInDevice, index: int, name: str, terminal: int, low: float, high: float) -> None:
        """Create a voltage channel."""
        if terminal != -1 and not device.terminals(index) & CONFIGURATIONS[terminal]:
            raise NiError(-200077)
        covering = [limits for limits in device.ranges_v if limits[0] <= low and limits[1] >= high]
        if not covering:
            raise NiError(-200077)
        low_v, high_v = min(covering, key=lambda limits: limits[1] - limits[0])
        self.channels.append(Channel(name, device, index, low_v, high_v))

    def configure(self, rate_hz: float, samples: int, *, finite: bool) -> None:
        """Set rate and buffer; the buffer is at least what the driver would choose itself."""
        self.rate_hz = rate_hz
        self._total = samples if finite else None
        self.buffer = (
            samples if finite else max(samples, 1000 if rate_hz <= 100 else 10_000 if rate_hz <= 10e3 else 100_000)
        )

    def wait_for(self, edge: DigitalEdge | AnalogEdge, pretrigger: int = 0) -> None:
        """Wait for an edge; refuse what the device does not have."""
        device = self.device
        if isinstance(edge, DigitalEdge):
            if edge.terminal not in [f"/{device.name}/{line}" for line in device.trigger_lines]:
                raise NiError(NO_SUCH_TERMINAL)
        elif not device.analog_trigger or edge.source not in [channel.name for channel in self.channels]:
            raise NiError(NO_SUCH_TERMINAL)
        if not device.trigger_usage & (REFERENCE if pretrigger else START):
            raise NiError(-200452)
        self._trigger = Trigger(edge, pretrigger)

    def edge_at(self, terminal: str) -> None:
        """Let the edge at a terminal come now; one that comes before the samples wanted from before it is not seen."""
        trigger = self._trigger
        if trigger is None or not self.running or trigger.at is not None or trigger.edge != DigitalEdge(terminal):
            return
        sampled = self._pace.acquired(self._mark, self.rate_hz)
        at = trigger.pretrigger if sampled is None else sampled
        if at >= trigger.pretrigger:
            trigger.at = at

    def commit(self) -> None:
        """Reserve the device."""
        if self.rate_hz > self.device.rate_limit_hz(len(self.channels)) * (1 + 1e-6):
            raise NiError(-200081)
        self.rate_hz = self.device.rate_in_force_hz(self.rate_hz)
        self.committed = True

    def start(self) -> None:
        """Begin to sample from the first sample of the recording."""
        self.commit()
        self._mark = self._pace.start()
        self._meter.started_at_s.append(self._mark)
        self._position = 0
        self._broken = 0
        if self._trigger is not None:
            self._trigger.at = None
        self.running = True

    def stop(self) -> None:
        """End sampling; waiting reads return."""
        self.running = False
        self._pace.condition.notify_all()

    def acquired(self) -> int | None:
        """Return the samples acquired for the reader; None: as many as anybody asks for."""
        count = self._pace.acquired(self._mark, self.rate_hz)
        length = self._signal.length
        count = count if length is None else length if count is None else min(count, length)
        if self._trigger is not None:
            first = self._first(self._trigger)
            if first is None or (count is not None and count <= first + self._trigger.pretrigger):
                return 0
            count = None if count is None else count - first
        return count if self._total is None else self._total if count is None else min(count, self._total)

    def _first(self, trigger: Trigger) -> int | None:
        """Return which sample since the start is the reader's first; None while the edge has not come."""
        edge = trigger.edge
        if trigger.at is None and isinstance(edge, AnalogEdge):
            (index,) = [channel.index for channel in self.channels if channel.name == edge.source]
            trigger.at = self._signal.crossing(index, trigger.pretrigger, edge.level_v, rising=edge.rising)
        return None if trigger.at is None else trigger.at - trigger.pretrigger

    def _offset(self) -> int:
        return 0 if self._trigger is None else self._first(self._trigger) or 0

    def available(self) -> int:
        """Return the samples waiting."""
        if not self.running:
            raise NiError(-200983)
        acquired = self.acquired()
        return 0 if acquired is None else acquired - self._position

    def coefficients(self, channel: Channel) -> tuple[float, ...]:
        """Return the scaling of one channel: the recording's own where it has one."""
        own = self._signal.scaling(channel.index)
        return own or channel.device.coefficients(channel.index, channel.low_v, channel.high_v)

    def read(self, wanted: int, timeout_s: float, *, codes: bool) -> tuple[np.ndarray | bytes, int, int]:
        """Return samples (n_channels, n) or the whole answer made before, n, and the status.

        The status is 0, or the timeout where n is less than wanted.
        """
        if not self.running:
            raise NiError(-200983, 0)
        if self._broken:
            raise NiError(self._broken, 0)
        self._measure()
        self._wait(wanted, timeout_s)
        acquired = self.acquired()
        if acquired is not None and acquired - self._position > self.buffer:
            self._broken = OVERWRITTEN
            self._meter.overwritten += 1
            raise NiError(OVERWRITTEN, 0)
        count = wanted if acquired is None else max(0, min(wanted, acquired - self._position))
        samples = self._samples(count, codes=codes)
        self._position += count
        self._meter.reads += 1
        self._meter.samples += count
        return samples, count, 0 if count == wanted else TIMEOUT

    def _wait(self, wanted: int, timeout_s: float) -> None:
        if self._trigger is not None and self._first(self._trigger) is None:
            self._pace.wait_for_edge(timeout_s, lambda: not self.running or self._first(self._trigger) is not None)
            return
        last = self._offset() + self._position + wanted
        self._pace.wait(self._mark, self.rate_hz, last, timeout_s, lambda: not self.running)

    def _measure(self) -> None:
        acquired = self.acquired()
        if acquired is not None:
            waiting_s = (acquired - self._position) / self.rate_hz
            self._meter.longest_backlog_s = max(self._meter.longest_backlog_s, waiting_s)

    def _samples(self, count: int, *, codes: bool) -> np.ndarray | bytes:
        inputs = [channel.index for channel in self.channels]
        first = self._offset() + self._position
        if not codes:
            return self._signal.volts(inputs, first, count)
        made = self._made and self._made.answer(inputs, first, count)
        if made is not None:
            return made
        scaling = [self.coefficients(channel) for channel in self.channels]
        return self._signal.codes(inputs, first, count, scaling)
