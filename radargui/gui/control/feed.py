"""What the screen pulls from an acquisition: the ring and the live track; nothing here waits."""

from __future__ import annotations

from typing import Protocol

from radargui.acquisition.live_track import LiveTrack
from radargui.acquisition.ring import Ring
from radargui.model.digitisation import Digitisation
from radargui.model.setup import Setup


class Pulled(Protocol):
    """What the screen needs of an `Acquisition`."""

    @property
    def ring(self) -> Ring | None:
        """The last seconds of samples; None before the source is open."""

    @property
    def live(self) -> LiveTrack | None:
        """The last seconds of live estimates; None where there are none."""

    @property
    def digitisation(self) -> Digitisation | None:
        """As the source gave it; None before it is open."""


class Feed:
    """One acquisition under its setup, as panels see it.

    Parameters
    ----------
    acquisition
        What samples come through; already open.
    setup
        Under which it runs.
    """

    def __init__(self, acquisition: Pulled, setup: Setup) -> None:
        self.acquisition = acquisition
        self.setup = setup
        digitisation = acquisition.digitisation
        self.n_receivers = digitisation.n_receivers if digitisation else setup.n_receivers
        self.rate_hz = digitisation.sample_rate_hz if digitisation else setup.daq.rate_hz
        self.range_v = setup.daq.range_v

    @property
    def ring(self) -> Ring | None:
        """The last seconds of samples."""
        return self.acquisition.ring

    @property
    def live(self) -> LiveTrack | None:
        """The last seconds of live estimates."""
        return self.acquisition.live

    def samples(self, seconds: float) -> int:
        """Return how many samples so many seconds are."""
        return max(1, round(seconds * self.rate_hz))
