"""The acceleration of the first fall against the gravity of the laboratory's place."""

import math
from dataclasses import dataclass

from radargui.model.gravity import gravity_of_site, share_in_air
from radargui.model.result import RunResult
from radargui.model.rounding import COVERAGE, plain, quantity
from radargui.model.setup import Setup


@dataclass(frozen=True, slots=True)
class SiteCheck:
    """What was measured against what was to be expected.

    Attributes
    ----------
    site_g_m_s2, u_site_g_m_s2
        Gravity of the place and its standard uncertainty.
    expected_m_s2, u_expected_m_s2
        What a sphere of this density falls with there, in air.
    difference_m_s2
        Measured less expected.
    u_difference_m_s2
        Of both together; None where only the statistical uncertainty of g is known, which says nothing here.
    agrees
        Whether the difference is within two of these; None where that is not known.
    compared
        All this in a sentence.
    """

    site_g_m_s2: float
    u_site_g_m_s2: float
    expected_m_s2: float
    u_expected_m_s2: float
    difference_m_s2: float
    u_difference_m_s2: float | None
    agrees: bool | None
    compared: str

    @property
    def verdict(self) -> str:
        """What it says of the scale of lengths: "g agrees with the site's within 1.2 u", or not."""
        if self.u_difference_m_s2 is None:
            return "g cannot be compared with the site's: the antennas' uncertainty is not known"
        ratio = abs(self.difference_m_s2) / self.u_difference_m_s2
        if self.agrees:
            # never said to be nearer than it is
            return f"g agrees with the site's within {max(math.ceil(10.0 * ratio) / 10.0, 0.1):.1f} u"
        return f"g differs from the site's by {ratio:.1f} u: the calibration is suspect"


def site_check(result: RunResult) -> SiteCheck | None:
    """Return the check of a result; None without a fall, or where the setup does not say where it stands."""
    fall, budget = result.bounces.free_fall, result.uncertainty_budget
    if fall is None:
        return None
    combined = None if budget is None else budget.g_m_s2.combined
    return check_against_site(fall.g_m_s2, fall.u_g_m_s2, result.setup, combined)


def check_against_site(
    g_m_s2: float, u_g_m_s2: float | None, setup: Setup, u_combined_m_s2: float | None
) -> SiteCheck | None:
    """Return the check of g; None where the setup does not say where it stands.

    Parameters
    ----------
    g_m_s2, u_g_m_s2
        The acceleration measured, of one fall or the mean of several, which stays as it is; its statistical u.
    setup
        Its site, and the sphere's density for buoyancy and added mass.
    u_combined_m_s2
        Of the acceleration, with antennas, clock and wavelength in it; None where it is not known.
    """
    site, density = setup.site, setup.tracer.density_kg_m3
    found = gravity_of_site(site)
    if found is None:
        return None
    g, u_g, is_stated = found
    origin = "the site's" if is_stated else f"normal gravity at {site.latitude_deg:g}°, {site.height_m:g} m"
    # buoyancy, and half the displaced air that moves with a sphere (Landau & Lifshitz, Fluid Mechanics, 11)
    gas = setup.air.gas
    share, u_air = share_in_air(density, gas), gas.u_density_kg_m3 / gas.density_kg_m3
    expected, u_expected = g * share, math.hypot(u_g, u_air * g * (1.0 - share))
    difference = g_m_s2 - expected
    u = None if u_combined_m_s2 is None else math.hypot(u_combined_m_s2, u_expected)
    # with the statistical u alone they would nearly always differ: antennas are known to half a degree
    agrees = None if u is None else abs(difference) <= COVERAGE * u
    air = "nothing for air, the sphere's density is not given"
    if density is not None:
        air = f"{plain(100.0 * (1.0 - share), 2)} % that air takes off a sphere of {density:g} kg/m³"
    vacuum = "" if setup.radar.index > 1.0 else " The wavelength is that of vacuum: in air g is 0.03 % smaller."
    verdict = {
        None: "no more can be said without the antennas' uncertainty",
        True: f"they agree within {COVERAGE:g} u",
        False: f"they differ by more than {COVERAGE:g} u",
    }[agrees]
    compared = (
        f"Measured {quantity(g_m_s2, u_combined_m_s2 or u_g_m_s2, 'm/s²')}, expected "
        f"{quantity(expected, u_expected, 'm/s²')}: {origin} {plain(g, 6)} m/s² less {air}. "
        f"Difference {quantity(difference, u, 'm/s²')}: {verdict}.{vacuum}"
    )
    return SiteCheck(g, u_g, expected, u_expected, difference, u, agrees, compared)
