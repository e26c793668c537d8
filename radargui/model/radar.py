"""The radar of the setup file: transmitter, receivers, tracer, floor."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator

from radargui.model.section import Coordinate, ExactWhole, Real, Section, Vector

SPEED_OF_LIGHT_M_S = 299_792_458.0


class Radar(Section):
    """Transmitted wave and the sign of the phase."""

    frequency_hz: Annotated[Real, Field(ge=1e8, le=1e12)] = 10.0e9
    phase_sign: Annotated[Literal[-1, 1], ExactWhole] = 1

    @property
    def wavelength_m(self) -> float:
        """Wavelength c / f0 in air taken as vacuum."""
        return SPEED_OF_LIGHT_M_S / self.frequency_hz


Distance = Annotated[Real, Field(gt=0.0, le=100.0)]
Uncertainty = Annotated[Real, Field(ge=0.0, le=1.0)]
AngleUncertainty = Annotated[Real, Field(ge=0.0, le=45.0)]


class Transmitter(Section):
    """Transmitter on the +z axis, pointing to -z."""

    distance_m: Distance
    u_distance_m: Uncertainty | None = None


class Receiver(Section):
    """One receiver at distance * (sin tilt cos azimuth, sin tilt sin azimuth, cos tilt)."""

    tilt_deg: Annotated[Real, Field(ge=0.0, le=180.0)]
    azimuth_deg: Annotated[Real, Field(ge=-360.0, le=360.0)]
    distance_m: Distance
    u_tilt_deg: AngleUncertainty | None = None
    u_azimuth_deg: AngleUncertainty | None = None
    u_distance_m: Uncertainty | None = None


class Tracer(Section):
    """The sphere and the place where its centre hangs before it falls."""

    diameter_m: Annotated[Real, Field(gt=0.0, le=0.5)] = 0.010
    release_position_m: Vector = (0.0, 0.0, 0.12)
    u_release_m: Uncertainty | None = None


class Floor(Section):
    """Where the sphere's centre is when it touches, and the direction away from the floor."""

    height_m: Coordinate | None = None
    normal: Vector = (0.0, 0.0, 1.0)

    @field_validator("normal")
    @classmethod
    def _has_a_direction(cls, normal: Vector) -> Vector:
        length = float(np.linalg.norm(normal))
        if length < 1e-6:
            raise ValueError("allowed: any direction, not the zero vector")
        return (normal[0] / length, normal[1] / length, normal[2] / length)
