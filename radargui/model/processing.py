"""The processing of the setup file: which correction, which geometry."""

from typing import Literal

from radargui.model.section import Section

Correction = Literal["joint", "adaptive", "published", "ellipse", "none"]
Geometry = Literal["exact", "plane"]


class Processing(Section):
    """How samples become a track.

    Attributes
    ----------
    correction
        See method.md.
    geometry
        plane: the antennas taken as infinitely far away.
    """

    correction: Correction = "joint"
    geometry: Geometry = "exact"
