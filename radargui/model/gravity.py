"""Gravity at a site, and what air takes off a falling sphere by drag and buoyancy.

Compute from temperature, pressure and humidity what air does to the wavelength and to a falling sphere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

from pydantic import Field, model_validator

from radargui.model.radar import Site
from radargui.model.section import Real, Section

ASSUMED_AIR = {"u_temperature_c": 0.5, "u_pressure_hpa": 2.0, "u_humidity_percent": 5.0}
"""Standard uncertainties where the setup gives none: a thermometer, a barometer and a hygrometer of the household."""
_DRY, _VAPOUR, _VAPOUR_2 = 77.6890, 71.2952, 375463.0  # K/hPa, K/hPa, K^2/hPa (`Air.refractive_index`)
_R_DRY, _R_VAPOUR = 287.05, 461.5
"""Gas constants of dry air and of water vapour, J/(kg K)."""
_SUTHERLAND, _SUTHERLAND_K = 1.458e-6, 110.4  # kg/(m s K^1/2), K: U.S. Standard Atmosphere 1976, eq. 51


class Gas(NamedTuple):
    """The gas that a sphere falls through.

    Attributes
    ----------
    density_kg_m3, u_density_kg_m3
        Density and its standard uncertainty.
    viscosity_m2_s
        Kinematic.
    """

    density_kg_m3: float
    u_density_kg_m3: float
    viscosity_m2_s: float


USUAL_AIR = Gas(1.2, 0.12, 1.51e-5)
"""Of dry air at 20 degrees C and 1013 hPa (1.204); weather and a laboratory on a hill change it by 10 %."""


class Air(Section):
    """Air of the laboratory; it gives the refractive index, which `radar.refractive_index` then leaves out.

    Attributes
    ----------
    temperature_c, u_temperature_c
        Of the air where the sphere falls.
    pressure_hpa, u_pressure_hpa
        As a barometer in the room shows it, not reduced to the level of the sea as weather reports have it.
    humidity_percent, u_humidity_percent
        Relative.
    """

    temperature_c: Annotated[Real, Field(ge=-40.0, le=60.0)] | None = None
    u_temperature_c: Annotated[Real, Field(ge=0.0, le=30.0)] | None = None
    pressure_hpa: Annotated[Real, Field(ge=300.0, le=1100.0)] | None = None
    u_pressure_hpa: Annotated[Real, Field(ge=0.0, le=300.0)] | None = None
    humidity_percent: Annotated[Real, Field(ge=0.0, le=100.0)] | None = None
    u_humidity_percent: Annotated[Real, Field(ge=0.0, le=100.0)] | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Air:
        missing = [name for name in _STATE if getattr(self, name) is None]
        if missing and any(value is not None for _, value in self):
            raise ValueError(f"{missing[0]} is missing, allowed: temperature_c, pressure_hpa and humidity_percent")
        return self

    @property
    def is_known(self) -> bool:
        """Whether the setup states the air."""
        return self.temperature_c is not None

    @property
    def assumed(self) -> dict[str, float]:
        """Uncertainties that are assumed because the setup states none, by name; empty without `[air]`."""
        return {name: u for name, u in ASSUMED_AIR.items() if self.is_known and getattr(self, name) is None}

    @property
    def refractive_index(self) -> float:
        """Refractive index for radio waves: 10^6 (n - 1) = 77.6890 p_d/T + 71.2952 p_w/T + 375463 p_w/T^2.

        The "best average" of Rüeger, FIG XXII International Congress, Washington 2002; p_d and p_w are the pressures of
        dry air and of vapour in hPa, T is in kelvin. 1 where the setup says nothing of the air.
        """
        return _index(*self._state) if self.is_known else 1.0

    @property
    def u_refractive_index(self) -> float:
        """Its standard uncertainty by those of temperature, pressure and humidity."""
        return self._u_of(_index)

    @property
    def gas(self) -> Gas:
        """Density and viscosity; usual values where the setup does not state the air."""
        if not self.is_known:
            return USUAL_AIR
        density, kelvin = _density(*self._state), self._state[0] + 273.15
        viscosity = _SUTHERLAND * kelvin**1.5 / (kelvin + _SUTHERLAND_K)
        return Gas(density, self._u_of(_density), viscosity / density)

    @property
    def _state(self) -> tuple[float, float, float]:
        return self.temperature_c or 0.0, self.pressure_hpa or 0.0, self.humidity_percent or 0.0

    def _u_of(self, value: Callable[[float, float, float], float]) -> float:
        """Return the standard uncertainty of a function of the state, by differences over u (GUM, 5.1.3, note 2)."""
        if not self.is_known:
            return 0.0
        changes = []
        for number, (name, usual) in enumerate(ASSUMED_AIR.items()):
            given = getattr(self, name)
            above, below = list(self._state), list(self._state)
            above[number] += usual if given is None else given
            below[number] -= usual if given is None else given
            changes.append(0.5 * (value(*above) - value(*below)))
        return math.hypot(*changes)


_STATE = ("temperature_c", "pressure_hpa", "humidity_percent")


def _vapour_hpa(temperature_c: float, humidity_percent: float) -> float:
    """Return the pressure of the vapour; saturated over water by Magnus' formula (WMO-No. 8, 2018, annex 4.B)."""
    return 0.01 * humidity_percent * 6.112 * math.exp(17.62 * temperature_c / (243.12 + temperature_c))


def _index(temperature_c: float, pressure_hpa: float, humidity_percent: float) -> float:
    kelvin, vapour = temperature_c + 273.15, _vapour_hpa(temperature_c, humidity_percent)
    n = _DRY * (pressure_hpa - vapour) + _VAPOUR * vapour + _VAPOUR_2 * vapour / kelvin
    return 1.0 + 1e-6 * n / kelvin


def _density(temperature_c: float, pressure_hpa: float, humidity_percent: float) -> float:
    """Return the density of moist air, both parts as ideal gases (within 0.1 % in a laboratory), kg/m^3."""
    kelvin, vapour = temperature_c + 273.15, _vapour_hpa(temperature_c, humidity_percent)
    return 100.0 * ((pressure_hpa - vapour) / _R_DRY + vapour / _R_VAPOUR) / kelvin


NOMINAL_GRAVITY_M_S2 = 9.81
"""Free fall at sea level in 49 degrees latitude (WGS 84); 9.780 at the equator to 9.832 at the poles.

What is expected where the setup does not say where it stands, see `expected_gravity_m_s2`; no rule uses it by itself.
Standard gravity (9.80665) is no better a guess.
"""
U_NOMINAL_GRAVITY_M_S2 = 0.015
"""Of it where no site is given: from the equator to the poles, evenly spread."""
U_ANYWHERE_M_S2 = 0.03
"""The same as the prior of an estimate: twice as wide, for what it bends is the whole geometry."""
TIDES_M_S2 = 2e-6
"""By which g of a place changes in a day: no gravity is known better to whom it is only stated."""
EARTH_GRAVITY_M_S2 = (9.76, 9.84)
"""Of all its places: from Huascaran, 9.764, to the pole, 9.834 (Hirt et al., Geophys. Res. Lett. 40, 4279, 2013)."""
U_NORMAL_GRAVITY_M_S2 = 5e-4
"""Free-air anomaly, root mean square over land: mountains and rock that the ellipsoid does not know, 50 mGal."""
_DRAG_COEFFICIENT, _DRAG_REYNOLDS = 0.36, 280.0  # c and Re1 of `drag_of_sphere`
_U_DRAG_SHARE = 0.2
"""Of k of a sphere whose density is given, relative: a wake that has not grown yet, weather."""
_METAL_KG_M3 = 5000.0  # between aluminium and steel
_EQUATOR_M_S2, _K, _E2 = 9.7803253359, 1.93185265241e-3, 6.69437999013e-3  # WGS 84 (NIMA TR8350.2): gamma_e, k, e^2
_A_M, _FLATTENING, _M = 6378137.0, 1.0 / 298.257223563, 3.44978650684e-3  # the same: a, f, m = omega^2 a^2 b / GM


def normal_gravity_m_s2(latitude_deg: float, height_m: float) -> float:
    """Return the normal gravity of WGS 84 (NIMA TR8350.2, 2000, eqs. 4-1 and 4-3).

    gamma = gamma_e (1 + k s) / sqrt(1 - e^2 s), s = sin^2(latitude) (Somigliana), times
    1 - 2 (1 + f + m - 2 f s) h / a + 3 (h / a)^2.

    Parameters
    ----------
    latitude_deg
        Geodetic.
    height_m
        Above the ellipsoid; that above the sea differs by up to 0.1 km, 3e-4 m/s^2.
    """
    s, h = math.sin(math.radians(latitude_deg)) ** 2, height_m / _A_M
    on_ellipsoid = _EQUATOR_M_S2 * (1.0 + _K * s) / math.sqrt(1.0 - _E2 * s)
    return on_ellipsoid * (1.0 - 2.0 * (1.0 + _FLATTENING + _M - 2.0 * _FLATTENING * s) * h + 3.0 * h * h)


def gravity_of_site(site: Site) -> tuple[float, float, bool] | None:
    """Return g of a place, its u, and whether the setup states it (else normal gravity); None where it is not stated.

    A g that is stated without u gets the u of normal gravity.
    """
    if site.g_m_s2 is not None:
        return site.g_m_s2, U_NORMAL_GRAVITY_M_S2 if site.u_g_m_s2 is None else site.u_g_m_s2, True
    if site.latitude_deg is not None and site.height_m is not None:
        return normal_gravity_m_s2(site.latitude_deg, site.height_m), U_NORMAL_GRAVITY_M_S2, False
    return None


def expected_gravity_m_s2(site: Site) -> float:
    """Return the g that rules expect at a site: what the setup says of it, else the nominal one.

    It is used where a rule asks whether something falls, when it lands or how fast it is; air does not matter there.
    """
    return g_and_u_of_site(site)[0]


def g_and_u_of_site(site: Site) -> tuple[float, float]:
    """Return g of a site and its u, m/s^2; where none is told, the nominal one and that of all places."""
    here = gravity_of_site(site)
    return (NOMINAL_GRAVITY_M_S2, U_NOMINAL_GRAVITY_M_S2) if here is None else here[:2]


def fall_time_s(way_m: float, gravity_m_s2: float) -> float:
    """Return how long a fall from rest takes for some way: sqrt(2 h / g)."""
    return math.sqrt(2.0 * way_m / gravity_m_s2)


def fall_speed_m_s(way_m: float, gravity_m_s2: float) -> float:
    """Return how fast a fall from rest is after some way: sqrt(2 g h)."""
    return math.sqrt(2.0 * gravity_m_s2 * way_m)


def expected_gravity(site: Site, density_kg_m3: float | None, air: Gas = USUAL_AIR) -> tuple[float, float]:
    """Return the acceleration that a sphere falls with at a site, drag apart, and its u; anywhere where none is told.

    Buoyancy is part of it; of a sphere whose density is not given it is that on metal, and as uncertain as it is large.
    """
    here, in_air = gravity_of_site(site), share_in_air(density_kg_m3 or _METAL_KG_M3, air)
    g, u = (NOMINAL_GRAVITY_M_S2, U_ANYWHERE_M_S2) if here is None else here[:2]
    u_buoyancy = 0.0 if density_kg_m3 is not None else (1.0 - in_air) * g
    return in_air * g, math.hypot(in_air * u, u_buoyancy)


def share_in_air(density_kg_m3: float | None, air: Gas = USUAL_AIR) -> float:
    """Return the acceleration of a sphere that falls in air over g, drag apart; 1 where its density is not given.

    (1 - r) / (1 + r / 2), r = density of air over that of the sphere: buoyancy, and the air that must move along, half
    the sphere's volume (Landau & Lifshitz, Fluid Mechanics, 11): 0.023 % less for steel.
    """
    if density_kg_m3 is None:
        return 1.0
    # the air that moves along is not weighed but must be accelerated too
    r = air.density_kg_m3 / density_kg_m3
    return (1.0 - r) / (1.0 + 0.5 * r)


class Drag(NamedTuple):
    """Drag of air, a = -k (|v| + v1) v.

    Attributes
    ----------
    k_1_m, u_k_1_m
        k and its standard uncertainty, 1/m.
    slow_m_s, u_slow_m_s
        v1, at which the linear part equals the quadratic one, and its standard uncertainty.
    """

    k_1_m: float
    u_k_1_m: float
    slow_m_s: float
    u_slow_m_s: float


NO_DRAG = Drag(0.0, 0.0, 0.0, 0.0)
UNKNOWN_DRAG = Drag(0.0, 0.04, 0.0, 0.0)
"""Of a body nobody has described: 10 mm of steel have k = 0.005 1/m, of light plastic 0.05."""


def drag_of_sphere(diameter_m: float, density_kg_m3: float | None, air: Gas = USUAL_AIR) -> Drag:
    """Return the drag of a sphere in air; one of which no density is given is of metal, and k hardly known.

    c_d = c (1 + Re1 / Re) with c = 0.36, Re1 = 280 is within 3 % of the standard drag curve from Re = 300 to 1500
    (after Clift & Gauvin, Proc. Chemeca 1, 14, 1970): 0.45 to 2.3 m/s at 10 mm; slower there is next to no drag. Then
    k = 3 c rho_air / (4 rho d), v1 = Re1 nu / d. From rest to 2.5 m/s the curve has the best Re1 between 250 and 350.
    """
    k = 0.75 * _DRAG_COEFFICIENT * air.density_kg_m3 / ((density_kg_m3 or _METAL_KG_M3) * diameter_m)
    u = UNKNOWN_DRAG.u_k_1_m if density_kg_m3 is None else _U_DRAG_SHARE * k
    slow_m_s = _DRAG_REYNOLDS * air.viscosity_m2_s / diameter_m
    return Drag(k, u, slow_m_s, _U_DRAG_SHARE * slow_m_s)
