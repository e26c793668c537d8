"""What the screen pulls from an acquisition: the ring and the live track; nothing here waits."""

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.live_track import LiveTrack
from radargui.acquisition.ring import Ring
from radargui.model.setup import Setup


class Feed:
    """One acquisition under its setup, as panels see it.

    Parameters
    ----------
    acquisition
        What samples come through; already open.
    setup
        Under which it runs.
    """

    def __init__(self, acquisition: Acquisition, setup: Setup) -> None:
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
