"""Spectra of I + jQ: Doppler lines by frequency and by speed of the path, hum of the mains by name."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QVBoxLayout, QWidget

from radargui.acquisition.baseband import Line, Spectrum
from radargui.gui.layout import fill
from radargui.gui.plots.plot import Plot
from radargui.gui.plots.ranges import SteadyRange
from radargui.gui.scopes.shown import Follower, Shown
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray

BANDS_HZ = (100.0, 300.0, 1000.0, 3000.0, 10000.0, 100_000.0)
"""Half bands that may be chosen: from hum and slow swings to the converter's own noise."""
_EVERY = 4
"""Frames: eight spectra a second are read well, and cost little."""
_LEAST_V = 1e-6
"""Below any converter's noise: what is nothing at all, such as a simulation without noise, is drawn here."""
_MOST_POINTS = 4000
"""Of a curve: more than the pixels of any screen; where there are more, the highest of neighbours."""


def decibels(amplitude_v: FloatArray) -> FloatArray:
    """Return 20 log10(amplitude / 1 V)."""
    return np.asarray(20.0 * np.log10(np.maximum(amplitude_v, _LEAST_V)))


class SpectrumPlot(Plot):
    """All receivers in one plot; the upper axis has the speed of the path."""

    def __init__(self, theme: Theme) -> None:
        self._per_hz = 0.0
        super().__init__(
            theme, "Doppler frequency [Hz], positive: the path gets longer", "amplitude [dB re 1 V]", live=True
        )
        self.getPlotItem().showAxis("top")
        self._speed.setStyle(tickLength=-4)
        self._speed.setLabel("speed of the path, dL/dt [m/s]")
        # not before the wavelength is known
        self._speed.setStyle(showValues=False)
        self.setXRange(-BANDS_HZ[1], BANDS_HZ[1], padding=0)
        self._range = SteadyRange()
        self.curves_ = [self.fast_line(f"receivers.{number}", f"Rx {number + 1}") for number in range(4)]
        self._mains = self.marker("text", "t", 9, "mains")
        self.setYRange(-100.0, 0.0, padding=0)

    @property
    def _speed(self) -> pg.AxisItem:
        return self.getPlotItem().getAxis("top")

    def set_scale(self, wavelength_m: float, half_band_hz: float) -> None:
        """Show +-half the band; the upper axis counts wavelength times frequency."""
        self._per_hz = wavelength_m
        self._speed.setScale(wavelength_m)
        self._speed.setStyle(showValues=True)
        self.setXRange(-half_band_hz, half_band_hz, padding=0)

    def also(self, value: float, axis: str = "bottom") -> str:
        """Return a frequency as a speed."""
        return f" = {value * self._per_hz:.3f} m/s" if axis == "bottom" else ""

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        super().retheme()
        self._speed.setPen(pg.mkPen(self.colour("line")))
        self._speed.setTextPen(pg.mkPen(self.colour("text")))

    def draw(self, spectrum: Spectrum, mains: list[Line]) -> None:
        """Draw spectra, and a mark at each line of the mains."""
        size = -(-spectrum.frequency_hz.size // _MOST_POINTS)
        edges = np.arange(0, spectrum.frequency_hz.size, size)
        level = decibels(np.maximum.reduceat(spectrum.amplitude_v, edges, axis=1))
        for curve, values in zip(self.curves_, level, strict=False):
            curve.setData(spectrum.frequency_hz[edges], values)
        at = np.array([line.frequency_hz for line in mains])
        self._mains.setData(at, decibels(np.array([line.amplitude_v for line in mains])) + 3.0)
        floor = float(np.median(level))
        if self._range.fit(floor - 15.0, float(level.max()) + 5.0):
            self.setYRange(*self._range.span, padding=0)


class SpectrumView(QWidget):
    """Spectra of the window that ends with what is shown; beneath them the lines in words."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.words = QLabel()
        self.words.setContentsMargins(6, 0, 6, 2)
        self.words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._column = fill(QVBoxLayout(self), self.words)
        self.half_band_hz = BANDS_HZ[1]
        self._follower = Follower()
        self._frame = 0
        self._drawn: tuple[object, ...] = ()
        self.spectrum: Spectrum | None = None
        self.show_nothing()

    @cached_property
    def plot(self) -> SpectrumPlot:
        """Made when it is first looked at: plots are what a new window waits for."""
        made = SpectrumPlot(self._theme)
        self._column.insertWidget(0, made, 1)
        return made

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Make the plot."""
        super().showEvent(event)
        self.plot  # noqa: B018 - makes it

    def show_nothing(self) -> None:
        """Forget what was shown."""
        if "plot" in vars(self):
            self.plot.show_nothing()
        self.spectrum, self._drawn = None, ()
        self.words.setText("Start shows the spectrum of what comes in")

    def draw(self, shown: Shown) -> None:
        """Draw what is new; called each frame."""
        band = self._follower.follow(shown, self.half_band_hz)
        self._frame += 1
        state = (band, band.end)
        if state == self._drawn or self._frame % _EVERY:
            return
        spectrum = band.spectrum()
        if spectrum is None:
            self.words.setText("Too few samples since the last ones that were lost")
            return
        if not self._drawn or self._drawn[0] is not band:
            self.plot.set_scale(shown.setup.radar.wavelength_m, band.half_band_hz)
        self._drawn, self.spectrum = state, spectrum
        receivers = range(spectrum.amplitude_v.shape[0])
        mains = {receiver: spectrum.mains(receiver) for receiver in receivers}
        self.plot.draw(spectrum, [line for lines in mains.values() for line in lines])
        lines = [self._line(shown, spectrum, receiver, mains[receiver]) for receiver in receivers]
        said = f"{spectrum.span_s:.2g} s of samples, so lines {spectrum.resolution_hz:.2g} Hz apart are told apart"
        self.words.setText("\n".join((*lines, said)))
        self.words.setToolTip(self.words.text())

    @staticmethod
    def _line(shown: Shown, spectrum: Spectrum, receiver: int, mains: list[Line]) -> str:
        line = spectrum.strongest(receiver)
        said = "no line above the noise"
        if line is not None:
            speed = shown.speed_m_s(line.frequency_hz)
            said = f"strongest {line.frequency_hz:+.1f} Hz = {speed:+.3f} m/s, {_level(line)}"
        hum = ", ".join(f"{one.frequency_hz:.1f} Hz {_level(one)}" for one in mains)
        return f"Rx {receiver + 1}: {said}" + (f"; mains ▼ {hum}" if hum else "")


def _level(line: Line) -> str:
    return f"{float(decibels(np.array(line.amplitude_v))):.1f} dB"
