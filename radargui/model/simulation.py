"""The simulated source of the setup file: scene, mismatch, noise and converter."""

import math
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.section import Flag, Real, Section, Whole

Scene = Literal["drop", "circle", "pendulum", "bed", "rest"]
Sphere = Literal["metal", "point"]
Relative = Annotated[Real, Field(ge=0.0, le=0.5)]
WallDistance = Annotated[Real, Field(gt=0.0, le=10.0)]
WallAzimuth = Annotated[Real, Field(ge=-360.0, le=360.0)]
MismatchKind = Literal[
    "dc_offset", "gain_error", "quadrature_error", "bias", "amplitude_variation", "drift", "reflection", "mains"
]

_LARGEST_E = 0.98
"""A power law alone would make the last small bounces gain speed."""


class Simulation(Section):
    """Everything the simulated source needs; sizes of mismatch are relative to the amplitude of I.

    Attributes
    ----------
    scene
        drop: falls and bounces; bed: falls onto grains and stays; circle; pendulum; rest: nothing moves.
    seed
        Draws everything random: hardware and surroundings once, noise, drift and mains anew for each run.
    rest_s, settle_s
        How long the sphere rests before and after the motion.
    drop_height_m
        Fall from the release to the first impact; left out: down to `floor.height_m`, else 0.26 m.
    drag_per_m, drag_slow_m_s
        k and v1 of the air's drag on a falling sphere (drop, bed), a = g - k (|v| + v1) v. One drag coefficient c_d is
        v1 = 0, k = 3 rho_air c_d / (4 rho_sphere d); the standard curve of a sphere of 10 mm is v1 = 0.42 m/s with
        k = 0.0042 1/m for steel, 0.04 for light plastic. Circle and pendulum know no air.
    lateral_speed_m_s, lateral_azimuth_deg
        Drift of a falling sphere; the azimuth is also the direction of the circle's middle and of the swing.
    restitution
        e of every impact; 0: a dead stop.
    restitution_exponent
        n of e = restitution (v / (1 m/s))^-n, v the speed before the impact; at most 0.98.
    restitution_scatter
        Standard deviation of e from impact to impact, anew for each run; e stays between 0 and 0.98.
    kick_m_s
        Standard deviation of the velocity that each impact adds in every direction along the floor, anew for each run.
    floor_tilt_deg, floor_tilt_azimuth_deg
        How far and in which direction the floor's normal leans away from what `floor.normal` says.
    bed_depth_m
        How deep the sphere goes into the grains.
    circle_radius_m, circle_period_s, circle_tilt_deg
        A circle that starts at the release, its middle `tilt` below the horizontal.
    turns
        Turns of the circle; swings to and fro of the pendulum, rounded to half swings.
    sphere
        metal: scatters as Mie theory says, between antennas polarised as the setup says (0 degrees and the strongest
        where it does not), on the direct and on every mirrored path; point: alike in all directions. Left out: metal
        where `transmitter.polarization_deg` is given.
    amplitude_v
        Of I and Q at the release.
    beamwidth_deg
        Full width of each antenna's main lobe at half power; all look at the origin.
    mismatch
        Size of every kind of mismatch at once; each kind set beside it overrides it. Walls, 1/f noise and drag are
        not of these kinds: they are off until they are set.
    dc_offset
        Length of the offset of (I, Q), its direction random.
    gain_error
        Amplitude of Q over that of I is 1 + or - up to this.
    quadrature_error_deg
        Exactly this for all receivers; left out: + or - up to `mismatch` radians, random.
    bias
        Root mean square of an offset of (I, Q) that varies smoothly with position.
    amplitude_variation
        Root mean square of the logarithm of an amplitude that varies smoothly with position.
    drift
        Root mean square of an offset of (I, Q) that varies slowly with time.
    reflection
        Magnitude of the reflection coefficient of the container's bottom: seen from the tracer, the mirrored antenna
        over the real one, apart from range and lobe. Left out: what `[floor]` states, with the phase of its plate, and
        with what a metal sphere and it send to and fro. Either way it ends where `floor.size_m` says.
    wall_reflection
        Magnitude of every mirrored antenna over the real one, apart from range, for a tracer at the release: walls are
        met by the antennas' side lobes, so the coefficient of the wall itself would tell little. Phases random, one for
        the transmitter and one for each receiver.
    wall_distance_m, wall_azimuth_deg
        One or two upright walls: how far from the z axis and in which direction. An antenna beyond a wall shines
        through it and has no image in it.
    mains, mains_frequency_hz
        Largest amplitude of a pick-up at this frequency.
    flicker
        Root mean square of 1/f noise between 0.1 Hz and 1 kHz, independent in each of I and Q, whatever `noise` says.
    snr_db, noise
        White noise, 10 log10(A^2 / (2 sigma^2)) with A = `amplitude_v` and sigma of one channel; false: none.
    crosstalk
        Share of the channel before that the multiplexer leaves in each.
    adc_bits
        Bits of the converter over +-`daq.range_v`; 0: no converter, ideal volts.
    """

    scene: Scene = "drop"
    seed: Annotated[Whole, Field(ge=0)] = 1
    rest_s: Annotated[Real, Field(ge=0.0, le=60.0)] = 0.6
    settle_s: Annotated[Real, Field(ge=0.0, le=60.0)] = 0.6

    gravity_m_s2: Annotated[Real, Field(ge=0.1, le=30.0)] = NOMINAL_GRAVITY_M_S2
    drop_height_m: Annotated[Real, Field(gt=0.0, le=2.0)] | None = None
    restitution: Annotated[Real, Field(ge=0.0, lt=1.0)] = 0.8
    restitution_exponent: Annotated[Real, Field(ge=-0.5, le=0.5)] = 0.0
    restitution_scatter: Annotated[Real, Field(ge=0.0, le=0.2)] = 0.0
    drag_per_m: Annotated[Real, Field(ge=0.0, le=0.2)] = 0.0
    drag_slow_m_s: Annotated[Real, Field(ge=0.0, le=10.0)] = 0.0
    lateral_speed_m_s: Annotated[Real, Field(ge=0.0, le=5.0)] = 0.0
    lateral_azimuth_deg: Annotated[Real, Field(ge=-360.0, le=360.0)] = 30.0
    kick_m_s: Annotated[Real, Field(ge=0.0, le=1.0)] = 0.0
    floor_tilt_deg: Annotated[Real, Field(ge=0.0, le=20.0)] = 0.0
    floor_tilt_azimuth_deg: Annotated[Real, Field(ge=-360.0, le=360.0)] = 0.0
    bed_depth_m: Annotated[Real, Field(gt=0.0, le=0.2)] = 0.01
    circle_radius_m: Annotated[Real, Field(gt=0.0, le=0.5)] = 0.08
    circle_period_s: Annotated[Real, Field(gt=0.01, le=60.0)] = 2.0
    circle_tilt_deg: Annotated[Real, Field(ge=0.0, le=90.0)] = 45.0
    pendulum_length_m: Annotated[Real, Field(gt=0.01, le=10.0)] = 0.5
    pendulum_amplitude_deg: Annotated[Real, Field(gt=0.0, le=80.0)] = 8.0
    turns: Annotated[Real, Field(gt=0.0, le=1000.0)] = 2.0

    sphere: Sphere | None = None
    amplitude_v: Annotated[Real, Field(gt=0.0, le=60.0)] = 1.0
    beamwidth_deg: Annotated[Real, Field(ge=1.0, le=180.0)] = 15.0
    mismatch: Relative = 0.02
    dc_offset: Relative | None = None
    gain_error: Relative | None = None
    quadrature_error_deg: Annotated[Real, Field(ge=-45.0, le=45.0)] | None = None
    bias: Relative | None = None
    amplitude_variation: Relative | None = None
    drift: Relative | None = None
    reflection: Relative | None = None
    wall_reflection: Relative = 0.0
    wall_distance_m: Annotated[tuple[WallDistance, ...], Field(min_length=1, max_length=2)] = (0.3,)
    wall_azimuth_deg: Annotated[tuple[WallAzimuth, ...], Field(min_length=1, max_length=2, validate_default=True)] = (
        30.0,
    )
    mains: Relative | None = None
    mains_frequency_hz: Annotated[Real, Field(ge=10.0, le=400.0)] = 50.0

    flicker: Relative = 0.0

    snr_db: Annotated[Real, Field(ge=0.0, le=400.0)] = 40.0
    noise: Flag = True
    crosstalk: Annotated[Real, Field(ge=-0.1, le=0.1)] = 0.0
    adc_bits: Annotated[Whole, Field(ge=0, le=16)] = 16

    @field_validator("wall_azimuth_deg")
    @classmethod
    def _an_azimuth_for_each_wall(cls, azimuths: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        distances = info.data.get("wall_distance_m", azimuths)
        if len(distances) != len(azimuths):
            raise ValueError(f"allowed: as many values as in simulation.wall_distance_m = {list(distances)}")
        return azimuths

    def is_metal(self, *, polarized: bool) -> bool:
        """Return whether the sphere scatters as metal, for a setup that gives the transmitter's polarisation or not."""
        return polarized if self.sphere is None else self.sphere == "metal"

    def restitution_at(self, speed_m_s: float, deviation: float = 0.0) -> float:
        """Return e of an impact at a speed, `deviation` times its scatter away from the mean."""
        if not self.restitution_exponent and not self.restitution_scatter:
            return self.restitution
        e = self.restitution * speed_m_s**-self.restitution_exponent
        return float(min(max(e + deviation * self.restitution_scatter, 0.0), _LARGEST_E))

    def size(self, kind: MismatchKind) -> float:
        """Return the relative size of one kind of mismatch: its own value, else `mismatch`."""
        # given as an angle, the same for all receivers; its sign is no matter of size
        if kind == "quadrature_error":
            own = None if self.quadrature_error_deg is None else math.radians(abs(self.quadrature_error_deg))
        else:
            own = getattr(self, kind)
        return self.mismatch if own is None else float(own)
