"""What the setup states of the laboratory, beside what is true: exact, or wrong by as much as it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from benchmarks.world.antenna_values import AntennaValues, signal_share
from benchmarks.world.sphere import Sphere
from numpy.typing import NDArray

from radargui.model.daq import Daq
from radargui.model.radar import Floor, Radar, Receiver, Tracer, Transmitter
from radargui.model.setup import Setup

Stated = Literal["exact", "no-polarization", "drawn"]
STATED: tuple[Stated, ...] = get_args(Stated)
"""All exact with u = 0; the same without polarisations; each value off by a draw from the u that is stated."""

REFRACTIVE_INDEX = 1.00032
U_ANGLE_DEG, U_DISTANCE_M, U_RELEASE_M, U_DIAMETER_M = 0.5, 0.003, 0.001, 2e-5
U_POLARIZATION_DEG, U_FLOOR_TILT_DEG, U_FREQUENCY, U_CLOCK_PPM = 5.0, 0.3, 1e-6, 50.0
MIN_SHARE = 0.06
"""A setup file may state no receiver that gets less than 0.05 of the strongest signal; its other values are off too."""


@dataclass(frozen=True)
class TrueValues:
    """What is true of all that a setup states.

    Attributes
    ----------
    antennas
        The transmitter first.
    floor_is_known
        Whether an exact setup states the floor's normal too: a board that leans is seen to lean.
    """

    antennas: tuple[AntennaValues, ...]
    release_m: NDArray[np.float64]
    diameter_m: float
    density_kg_m3: float
    floor_normal: NDArray[np.float64]
    frequency_hz: float
    rate_hz: float
    skew_s: float
    range_v: float
    phase_sign: int
    floor_is_known: bool = False

    @property
    def wavenumber_rad_m(self) -> float:
        """K = 2 pi n f / c."""
        return 2.0 * np.pi * REFRACTIVE_INDEX * self.frequency_hz / 299_792_458.0


def setup_of(true: TrueValues, stated: Stated, rng: np.random.Generator) -> Setup:
    """Return the setup that the estimator gets; `drawn`: with values that are off, and the u they are off by."""
    share = 1.0 if stated == "drawn" else 0.0

    def off(value: float, u: float) -> float:
        return float(value + share * u * rng.standard_normal())

    transmitter, *receivers = true.antennas
    u_place = {"u_distance_m": share * U_DISTANCE_M}
    u_angles = {"u_tilt_deg": share * U_ANGLE_DEG, "u_azimuth_deg": share * U_ANGLE_DEG}

    polarizations_deg = _polarizations_deg(true, off)

    def polarization(number: int) -> dict[str, Any]:
        told = {"polarization_deg": polarizations_deg[number], "u_polarization_deg": share * U_POLARIZATION_DEG}
        return {} if stated == "no-polarization" else told

    normal = np.array([*(off(v, np.radians(U_FLOOR_TILT_DEG)) for v in true.floor_normal[:2]), true.floor_normal[2]])
    told = share or true.floor_is_known
    floor = {"normal": tuple(normal.tolist()), "u_tilt_deg": share * U_FLOOR_TILT_DEG} if told else {}
    return Setup(
        schema=1,
        radar=Radar(
            frequency_hz=off(true.frequency_hz, U_FREQUENCY * true.frequency_hz),
            u_frequency_hz=share * U_FREQUENCY * true.frequency_hz,
            refractive_index=REFRACTIVE_INDEX,
            phase_sign=true.phase_sign,
        ),
        transmitter=Transmitter(
            distance_m=off(transmitter.distance_m, U_DISTANCE_M),
            **u_place,
            **polarization(0),
        ),
        receiver=tuple(
            Receiver(
                tilt_deg=off(one.tilt_deg, U_ANGLE_DEG),
                azimuth_deg=off(one.azimuth_deg, U_ANGLE_DEG),
                distance_m=off(one.distance_m, U_DISTANCE_M),
                **u_angles,
                **u_place,
                **polarization(number),
            )
            for number, one in enumerate(receivers, 1)
        ),
        tracer=Tracer(
            diameter_m=off(true.diameter_m, U_DIAMETER_M),
            u_diameter_m=share * U_DIAMETER_M,
            density_kg_m3=true.density_kg_m3,
            release_position_m=tuple(off(v, U_RELEASE_M) for v in true.release_m),
            u_release_m=share * U_RELEASE_M,
        ),
        floor=Floor(**floor),
        daq=Daq(
            rate_hz=off(true.rate_hz, 1e-6 * U_CLOCK_PPM * true.rate_hz),
            u_clock_ppm=share * U_CLOCK_PPM,
            channel_skew_s=true.skew_s,
            range_v=true.range_v,
        ),
    )


def _polarizations_deg(true: TrueValues, off: Callable[[float, float], float]) -> list[float]:
    """Return the stated polarisations, the transmitter's first: none that a setup file is refused for."""
    sphere = Sphere(true.diameter_m / 2.0, true.wavenumber_rad_m)
    while True:
        stated = [replace(one, polarization_deg=off(one.polarization_deg, U_POLARIZATION_DEG)) for one in true.antennas]
        if min(signal_share(stated[0], one, sphere) for one in stated[1:]) > MIN_SHARE:
            return [one.polarization_deg for one in stated]
