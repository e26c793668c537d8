"""A setup as its file says it: the truth, or what somebody measured of it with the uncertainty that stands beside."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from benchmarks.world.antenna_values import AntennaValues, signal_share
from benchmarks.world.draws import Draws
from benchmarks.world.sphere import Sphere

Tables = dict[str, Any]

MIN_SHARE = 0.06
"""A setup may state no receiver that gets less than 0.05 of the strongest signal."""
U_DIAMETER_M, U_CLOCK_PPM, U_G_M_S2 = 2e-5, 50.0, 1e-3


@dataclass(frozen=True)
class Uncertainties:
    """By how much the values of a setup are off: standard deviations, which it states.

    Attributes
    ----------
    release_m, release_scatter_m
        Of the part that all drops of a session share, and of each drop about it; of each coordinate.
    distance_m
        Of every antenna's distance, and of the transmitter's place beside the axis.
    """

    angle_deg: float = 0.0
    distance_m: float = 0.0
    polarization_deg: float = 0.0
    release_m: float = 0.0
    release_scatter_m: float = 0.0
    diameter_m: float = 0.0
    clock_ppm: float = 0.0
    g_m_s2: float = 0.0


EXACT = Uncertainties()


def draw_uncertainties(value: Draws) -> Uncertainties:
    """Return those of an ordinary laboratory."""
    release_m = value.between("u_release_m", 3e-4, 2e-3)
    return Uncertainties(
        angle_deg=value.between("u_angle_deg", 0.1, 0.5),
        distance_m=value.between("u_distance_m", 1e-3, 5e-3),
        polarization_deg=value.between("u_polarization_deg", 1.0, 5.0),
        release_m=release_m,
        release_scatter_m=release_m * value.between("release_scatter", 0.1, 0.5),
        diameter_m=U_DIAMETER_M,
        clock_ppm=U_CLOCK_PPM,
        g_m_s2=U_G_M_S2,
    )


def told(true: Tables, u: Uncertainties, value: Draws, wavenumber_rad_m: float) -> Tables:
    """Return the tables of a setup that is off by its uncertainties, which stand beside the values.

    The transmitter's place beside the axis, `x_m` and `y_m` of the true tables, is never told: only its uncertainty.
    """
    tables = copy.deepcopy(true)
    rng = value.rng("told")

    def off(table: Tables, name: str, by: float, stated: float | None = None) -> None:
        if name in table:
            table[name] = float(table[name] + by * rng.standard_normal())
            table[f"u_{name}"] = by if stated is None else stated

    sender, tracer, daq = tables["transmitter"], tables["tracer"], tables["daq"]
    sender.pop("x_m"), sender.pop("y_m")
    sender |= {"u_x_m": u.distance_m, "u_y_m": u.distance_m}
    off(sender, "distance_m", u.distance_m)
    for receiver in tables["receiver"]:
        off(receiver, "tilt_deg", u.angle_deg)
        off(receiver, "azimuth_deg", u.angle_deg)
        receiver["azimuth_deg"] %= 360.0
        off(receiver, "distance_m", u.distance_m)
    release = np.array(tracer["release_position_m"])
    tracer["release_position_m"] = (release + u.release_m * rng.standard_normal(3)).tolist()
    tracer |= {"u_release_m": u.release_m, "u_release_scatter_m": u.release_scatter_m}
    off(tracer, "diameter_m", u.diameter_m)
    daq["rate_hz"] *= 1.0 + 1e-6 * u.clock_ppm * rng.standard_normal()
    daq["u_clock_ppm"] = u.clock_ppm
    if "site" in tables:
        off(tables["site"], "g_m_s2", u.g_m_s2)
    sphere = Sphere(true["tracer"]["diameter_m"] / 2.0, wavenumber_rad_m)
    _turn(tables, u.polarization_deg, value.rng("told polarization"), sphere)
    return tables


def _turn(tables: Tables, by_deg: float, rng: np.random.Generator, sphere: Sphere) -> None:
    """Turn the polarisations, where they are told, so that no receiver seems nearly blind."""
    antennas = [tables["transmitter"], *tables["receiver"]]
    if "polarization_deg" not in antennas[0]:
        return
    while True:
        stated = [one["polarization_deg"] + by_deg * rng.standard_normal() for one in antennas]
        sender, *receivers = (
            AntennaValues(one.get("tilt_deg", 0.0), one.get("azimuth_deg", 0.0), one["distance_m"], angle)
            for one, angle in zip(antennas, stated, strict=True)
        )
        if min(signal_share(sender, one, sphere) for one in receivers) > MIN_SHARE:
            break
    for one, angle in zip(antennas, stated, strict=True):
        one |= {"polarization_deg": float(angle % 180.0), "u_polarization_deg": by_deg}
