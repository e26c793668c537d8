"""What is connected to the inputs of the stand-in devices: the channels of a recording."""

from __future__ import annotations

from typing import Literal

import numpy as np

from radargui.model.recording import Recording

AtEnd = Literal["hold", "repeat", "end"]


class Signal:
    """Input k of a device gets channel k of the recording; inputs beyond get 0."""

    def __init__(self, recording: Recording, at_end: AtEnd) -> None:
        self._recording = recording
        self._volts: np.ndarray | None = None
        self._at_end = at_end

    @property
    def has_codes(self) -> bool:
        """Whether the recording itself is made of codes."""
        return self._recording.raw.dtype == np.int16

    @property
    def length(self) -> int | None:
        """Samples until nothing more comes; None: for ever."""
        return self._recording.n_samples if self._at_end == "end" else None

    def scaling(self, index: int) -> tuple[float, ...] | None:
        """Return the recording's own coefficients of one input."""
        scaling = self._recording.digitisation.scaling
        return scaling[index] if scaling is not None and index < len(scaling) else None

    def codes(self, inputs: list[int], first: int, count: int, coefficients: list[tuple[float, ...]]) -> np.ndarray:
        """Return int16 codes, shape (len(inputs), count)."""
        if self.has_codes:
            return self._taken(self._recording.raw, inputs, first, count)
        volts = self.volts(inputs, first, count)
        out = np.empty(volts.shape, dtype=np.int16)
        for row, (c0, c1, *_) in enumerate(coefficients):
            out[row] = np.clip(np.rint((volts[row] - c0) / c1), -32768, 32767)
        return out

    def volts(self, inputs: list[int], first: int, count: int) -> np.ndarray:
        """Return volts, shape (len(inputs), count)."""
        if self._volts is None:
            self._volts = self._recording.volts()
        return self._taken(self._volts, inputs, first, count)

    def crossing(self, index: int, first: int, level_v: float, *, rising: bool) -> int | None:
        """Return the first sample, from `first` on, at which an input has crossed a level; None: never."""
        volts = self.volts([index], 0, self._recording.n_samples)[0]
        above = volts >= level_v if rising else volts <= level_v
        crossings = np.flatnonzero(~above[:-1] & above[1:]) + 1
        later = crossings[crossings >= first]
        return int(later[0]) if later.size else None

    def _taken(self, source: np.ndarray, inputs: list[int], first: int, count: int) -> np.ndarray:
        length = source.shape[1]
        if first + count <= length:
            columns: slice | np.ndarray = slice(first, first + count)
        elif self._at_end == "repeat":
            columns = np.arange(first, first + count) % length
        else:
            columns = np.minimum(np.arange(first, first + count), length - 1)
        out = np.zeros((len(inputs), count), dtype=source.dtype)
        for row, index in enumerate(inputs):
            if index < source.shape[0]:
                out[row] = source[index, columns]
        return out
