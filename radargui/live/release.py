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
        """Tell that the place is not known any more.

        Parameters
        ----------
        seen
            False where a whole drop may have gone by unseen, for the signals were no circles.
        """
        self.began_anew = self._left = True
        if not seen and not self._fell:
            self._lies, self._left = True, False

    def goes(self, away_m: float) -> None:
        """Tell how far from the release the track is."""
        self._left |= away_m > FALLEN_M

    def fallen(self) -> None:
        """Tell that a drop has ended: a track that was lost in it lies somewhere, until a hand has moved it."""
        self._lies, self._left, self._fell = self.began_anew, False, True

    def hang_up(self, *, strayed: bool) -> bool:
        """Tell that a hand has moved it; return whether the track may begin at the release.

        Parameters
        ----------
        strayed
            Whether it was followed to another place: the track begins there, and says so.
        """
        if self._lies and not self._left:
            return False
        self.began_anew = strayed and not self._lies
        self._lies = self._fell = False
        return True
