"""The live memory: what the live corrections of earlier runs have learned, for the next run of a session."""

from __future__ import annotations

from radargui.correction.map_filter import MapFilter


class LiveMemory:
    """Holds one filter a receiver; empty until a live processor has used it. One acquisition at a time may."""

    def __init__(self) -> None:
        self._filters: list[MapFilter] = []
        self._rad_per_m = 0.0

    @property
    def is_warm(self) -> bool:
        """Whether a run can be followed from its first sample."""
        return bool(self._filters) and all(follower.started for follower in self._filters)

    def filters(self, rad_per_m: float, n_receivers: int) -> list[MapFilter]:
        """Return the filters for a radar; new ones where those of before belong to another one.

        Parameters
        ----------
        rad_per_m
            Phase over path length, sign included.
        n_receivers
            How many.
        """
        if len(self._filters) != n_receivers or rad_per_m != self._rad_per_m:
            self._filters = [MapFilter(rad_per_m) for _ in range(n_receivers)]
            self._rad_per_m = rad_per_m
        return self._filters
