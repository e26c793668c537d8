"""Decide whether a track that was lost may count as at the release again."""

from __future__ import annotations

FALLEN_M = 0.05
"""Farther from where it rested than this, it has left that place. By hand."""


class Release:
    """Remembers losses and drops until a hand has hung the tracer up.

    Attributes
    ----------
    began_anew
        See `LiveEstimate.began_anew`.
    """

    def __init__(self) -> None:
        self.began_anew = False
        # it lies where nobody knows; it has left that place; a drop has ended since it hung
        self._lies = self._left = self._fell = False

    def lose(self, *, seen: bool) -> None:
        """Note that the place is not known any more.

        Parameters
        ----------
        seen
            False if a whole drop may have passed unseen, because the signals were no circles.
        """
        self.began_anew = self._left = True
        if not seen and not self._fell:
            self._lies, self._left = True, False

    def goes(self, away_m: float) -> None:
        """Note how far from the release the track is."""
        self._left |= away_m > FALLEN_M

    def fallen(self) -> None:
        """Note that a drop has ended: a tracer that was lost in it lies somewhere until a hand has moved it."""
        self._lies, self._left, self._fell = self.began_anew, False, True

    def hang_up(self, *, strayed: bool) -> bool:
        """Note that a hand has moved the tracer; return whether the track may begin at the release.

        Parameters
        ----------
        strayed
            Whether the tracer was followed to another place: then the track begins there, and the estimate says so.
        """
        if self._lies and not self._left:
            return False
        self.began_anew = strayed and not self._lies
        self._lies = self._fell = False
        return True
