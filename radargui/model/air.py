"""Compute from temperature, pressure and humidity what air does to the wavelength and to a falling sphere."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

from pydantic import Field, model_validator

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
