"""The converter: volts to the codes of a device with a range and a number of bits."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray, RawArray
from radargui.model.daq import Daq
from radargui.model.simulation import Simulation

_CODES = 32768


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
        codes = np.rint(volts / (self._lsb_v * step)) * step
        return np.clip(codes, -_CODES, _CODES - 1).astype(np.int16)
