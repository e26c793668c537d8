"""Analytic drops for tests: exact heights, impacts and IQ."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

G = 9.81


@dataclass(frozen=True)
class Drop:
    """A sphere that rests, falls from `height_m` and bounces until it hops slower than 2 cm/s."""

    height_m: float = 0.25
    e: float = 0.8
    rest_s: float = 0.5
    settle_s: float = 0.5
    rate_hz: float = 20000.0

    @property
    def impact_s(self) -> FloatArray:
        fall = np.sqrt(2 * self.height_m / G)
        times, speed = [self.rest_s + fall], np.sqrt(2 * G * self.height_m) * self.e
        while speed > 0.02:
            times.append(times[-1] + 2 * speed / G)
            speed *= self.e
        return np.array(times)

    @property
    def time_s(self) -> FloatArray:
        return np.arange(round((self.impact_s[-1] + self.settle_s) * self.rate_hz)) / self.rate_hz

    def height(self, time_s: FloatArray) -> FloatArray:
        """Height above the floor at any time."""
        impact = self.impact_s
        out = np.where(time_s < self.rest_s, self.height_m, self.height_m - 0.5 * G * (time_s - self.rest_s) ** 2)
        speed = np.sqrt(2 * G * self.height_m)
        for begin, end in itertools.pairwise(impact):
            speed *= self.e
            d = time_s - begin
            out = np.where((time_s >= begin) & (time_s < end), speed * d - 0.5 * G * d * d, out)
        return np.where(time_s >= impact[-1], 0.0, out)
