"""The settings of processing: the correction and the geometry."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from radargui.model.plugins import plugins
from radargui.model.section import Flag, Section

CORRECTIONS = ("joint", "flights", "adaptive", "published", "ellipse", "none")


def _known_correction(name: str) -> str:
    if name not in CORRECTIONS and name not in (added := plugins("corrections")):
        raise ValueError(f"allowed: {', '.join((*CORRECTIONS, *added))}")
    return name


Correction = Annotated[str, AfterValidator(_known_correction), Field(json_schema_extra={"enum": list(CORRECTIONS)})]
Geometry = Literal["exact", "plane"]


class Processing(Section):
    """How samples become a track.

    Attributes
    ----------
    correction
        See method.md; also the name of a plug-in.
    geometry
        plane: the antennas taken as infinitely far away.
    pool_setup
        Whether the joint correction uses what the other runs of a session say of antennas, release and wavelength.
    """

    correction: Correction = "joint"
    geometry: Geometry = "exact"
    pool_setup: Flag = True
