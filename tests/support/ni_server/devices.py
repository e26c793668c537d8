"""The devices of the stand-in server: what they have and what they can do."""

from __future__ import annotations

from dataclasses import dataclass

RSE, NRSE, DIFF, PSEUDO_DIFF = 1, 2, 4, 8
"""Bits of the terminal configurations a physical channel supports."""

REFERENCE, START = 4, 8
"""Bits of the triggers an analogue input task can have."""

CONFIGURATIONS = {10083: RSE, 10078: NRSE, 10106: DIFF, 12529: PSEUDO_DIFF}
"""Values of a terminal configuration asked for, and their bits."""


@dataclass(frozen=True)
class StandInDevice:
    """One device; the defaults are a multiplexed 16 bit device."""

    name: str = "Dev1"
    product_type: str = "DAQPad-6015"
    serial: int = 0x0123ABCD
    n_channels: int = 16
    first_terminals: int = RSE | NRSE | DIFF  # of the lower half of the channels
    last_terminals: int = RSE | NRSE  # of the upper half: negative inputs of the lower one
    ranges_v: tuple[tuple[float, float], ...] = ((-0.05, 0.05), (-0.5, 0.5), (-5.0, 5.0), (-10.0, 10.0))
    max_single_hz: float = 200e3
    max_multi_hz: float = 200e3
    min_hz: float = 0.0119
    max_convert_hz: float = 200e3
    timebase_hz: float = 20e6
    simultaneous: bool = False
    raw_bits: int = 16
    scaling_told: bool = True
    analog_trigger: bool = False
    trigger_usage: int = START | REFERENCE
    trigger_lines: tuple[str, ...] = ("PFI0", "PFI1", "PFI2")

    def terminals(self, index: int) -> int:
        """Return the bits of the terminal configurations of one channel."""
        return self.first_terminals if index < (self.n_channels + 1) // 2 else self.last_terminals

    def coefficients(self, index: int, low_v: float, high_v: float) -> tuple[float, ...]:
        """Return c_k of volts = sum c_k code^k, a little different for each channel as on a calibrated device."""
        step = (high_v - low_v) / 65536.0
        return (low_v + 32768.0 * step + 1e-4 * step * (index + 1), step * (1.0 + 1e-5 * index), 0.0, 0.0)

    def convert_hz(self, n_channels: int, rate_hz: float) -> float:
        """Return the convert rate: the fastest and 10 us of padding, or evenly spread where that leaves no room."""
        padded = 1.0 / (1.0 / self.max_convert_hz + 10e-6)
        return padded if n_channels / padded <= 1.0 / rate_hz else min(n_channels * rate_hz, self.max_convert_hz)

    def rate_in_force_hz(self, rate_hz: float) -> float:
        """Return the nearest rate not below the one asked for that divides the timebase."""
        return self.timebase_hz / max(1, int(self.timebase_hz / rate_hz * (1.0 + 1e-12)))

    def rate_limit_hz(self, n_channels: int) -> float:
        """Return the highest rate of each of several channels."""
        return self.max_multi_hz if self.simultaneous else min(self.max_single_hz, self.max_multi_hz / n_channels)


def daqpad_6015(name: str = "Dev1") -> StandInDevice:
    """Multiplexed, 16 bit, 200 kS/s in all."""
    return StandInDevice(name=name)


def usb_6356(name: str = "Dev2") -> StandInDevice:
    """Simultaneous, 16 bit, 1.25 MS/s each."""
    return StandInDevice(
        name=name,
        product_type="USB-6356",
        serial=0x01D5A2F0,
        n_channels=8,
        first_terminals=DIFF,
        last_terminals=DIFF,
        ranges_v=((-1.0, 1.0), (-2.0, 2.0), (-5.0, 5.0), (-10.0, 10.0)),
        max_single_hz=1.25e6,
        max_multi_hz=1.25e6,
        simultaneous=True,
        analog_trigger=True,
        trigger_lines=tuple(f"PFI{number}" for number in range(16)),
    )


def delta_sigma(name: str = "Dev3") -> StandInDevice:
    """Simultaneous, 24 bit in 32: cannot be read as 16 bit codes."""
    return StandInDevice(
        name=name,
        product_type="PXIe-4497",
        serial=0x01A00001,
        n_channels=16,
        first_terminals=PSEUDO_DIFF | DIFF,
        last_terminals=PSEUDO_DIFF | DIFF,
        ranges_v=((-1.0, 1.0), (-10.0, 10.0)),
        max_single_hz=204.8e3,
        max_multi_hz=204.8e3,
        min_hz=100.0,
        simultaneous=True,
        raw_bits=32,
    )


def digital_only(name: str = "Dev4") -> StandInDevice:
    """No analogue input at all."""
    return StandInDevice(name=name, product_type="USB-6501", serial=0x01A00002, n_channels=0, trigger_lines=())
