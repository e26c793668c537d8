"""The simulated source of the setup file: scene, mismatch, noise, converter."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from radargui.model.section import Real, Section, Whole

Scene = Literal["drop", "circle", "pendulum", "bed", "rest"]
Relative = Annotated[Real, Field(ge=0.0, le=0.5)]


class Simulation(Section):
    """Everything the simulated source needs; sizes of mismatch are relative to the amplitude of I.

    `mismatch` sets the size of every kind at once; each kind set beside it overrides it.
    """

    scene: Scene = "drop"
    seed: Annotated[Whole, Field(ge=0)] = 1
    rest_s: Annotated[Real, Field(ge=0.0, le=60.0)] = 0.6
    settle_s: Annotated[Real, Field(ge=0.0, le=60.0)] = 0.6

    drop_height_m: Annotated[Real, Field(gt=0.0, le=2.0)] | None = None
    restitution: Annotated[Real, Field(ge=0.0, lt=1.0)] = 0.8
    lateral_speed_m_s: Annotated[Real, Field(ge=0.0, le=5.0)] = 0.0
    lateral_azimuth_deg: Annotated[Real, Field(ge=-360.0, le=360.0)] = 30.0
    bed_depth_m: Annotated[Real, Field(gt=0.0, le=0.2)] = 0.01
    circle_radius_m: Annotated[Real, Field(gt=0.0, le=0.5)] = 0.08
    circle_period_s: Annotated[Real, Field(gt=0.01, le=60.0)] = 2.0
    pendulum_length_m: Annotated[Real, Field(gt=0.01, le=10.0)] = 0.5
    pendulum_amplitude_deg: Annotated[Real, Field(gt=0.0, le=80.0)] = 8.0
    turns: Annotated[Real, Field(gt=0.0, le=1000.0)] = 2.0

    amplitude_v: Annotated[Real, Field(gt=0.0, le=60.0)] = 1.0
    beamwidth_deg: Annotated[Real, Field(gt=0.1, le=180.0)] = 15.0
    mismatch: Relative = 0.02
    dc_offset: Relative | None = None
    gain_error: Relative | None = None
    quadrature_error_deg: Annotated[Real, Field(ge=-45.0, le=45.0)] | None = None
    bias: Relative | None = None
    amplitude_variation: Relative | None = None
    drift: Relative | None = None
    reflection: Relative | None = None
    mains: Relative | None = None
    mains_frequency_hz: Annotated[Real, Field(ge=10.0, le=400.0)] = 50.0

    snr_db: Annotated[Real, Field(ge=0.0, le=400.0)] | None = 40.0
    adc_bits: Annotated[Whole, Field(ge=0, le=16)] = 16
    noise: Annotated[bool, Field(strict=True)] = True

    def size(self, kind: str) -> float:
        """Return the relative size of one kind of mismatch: its own value, else `mismatch`."""
        own = getattr(self, kind)
        return self.mismatch if own is None else float(own)
