"""The processing of the setup file: which correction, which geometry."""

from __future__ import annotations

from typing import Literal

from radargui.model.section import Section

Correction = Literal["joint", "adaptive", "published", "ellipse", "none"]
Geometry = Literal["exact", "plane"]


class Processing(Section):
    """How samples become a track."""

    correction: Correction = "joint"
    geometry: Geometry = "exact"
