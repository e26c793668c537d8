"""Which place of the setup is likely wrong by more than it says: flights and g against all its inputs at once."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.readout.input_response import InputResponse
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.assumed import UncertainInput, uncertain_inputs, usual_u
from radargui.model.gravity import gravity_of_site, share_in_air
from radargui.model.setup import Setup
from radargui.restitution.flight_fit import FlightFit

CONTRADICTED = "flights and g contradict the setup"
"""How the sentence begins."""
_EARTH_M_S2, _U_EARTH_M_S2 = 9.80, 0.02
"""g where the setup names no site: 9.76 to 9.84, evenly."""
_SIGMAS = 3.72
"""A place gains so much by chance once in ten thousand: as many deviations of a normal number."""
_LEAST_OFF, _LEAST_OFF_EXACT = 5.0, 20.0
"""Deviation of an input, in its u, or of one that is called exact in what a laboratory knows it to: less is no mistake.
Where all are exact, what no model has (the walls of a box: 14, laboratory 85000) has nothing else to show in."""
_WORTH_NAMING = 3.0
"""The same, of what is named beside it."""
_ALIKE, _ALIKE_SHARE = 10.0, 0.3
"""Places whose gains in chi-square differ by less, or by less than this share of the best, cannot be told apart: two
receivers exchanged gained 81, 71, 61 and 61 as release or receiver (laboratory seed 81410)."""
_FAR_DEG, _FAR_M = 45.0, 0.15
"""What is farther off is not told in numbers: the equations are linear, antennas and places are not."""
_FREE, _HELD = 1e-6, 1e6
"""Weights of the square of an input that is freed (what nothing shows stays where it is), and of an exact one."""


@dataclass(frozen=True, slots=True)
class SetupOutlier:
    """A place that is likely wrong.

    Attributes
    ----------
    off
        What has to be added to each of its inputs, in their u, by key.
    sentence
        For people.
    """

    off: dict[str, float]
    sentence: str

    def widening(self, key: str) -> float:
        """Return by how many u an input counts as uncertain: as far off as the run itself says."""
        return max(1.0, abs(self.off.get(key, 0.0)))


def setup_outlier(
    fit: FlightFit, keys: Sequence[str], responses: Sequence[InputResponse], setup: Setup
) -> SetupOutlier | None:
    """Return the place without whose u flights and g agree far better, all else within its u; None without one.

    Where inputs are off by a (in their u), chi-square of the flights, of g and of the inputs themselves is
    misfit + 2 c.a + a^T B a + (g - g0 + g'.a)^2 / u^2 + a^T a. Its least value over all a, less that without the last
    term for the inputs of one place, is chi-square distributed with as many degrees of freedom, if the setup is right.

    Parameters
    ----------
    fit
        Of the flights.
    keys, responses
        Of the inputs; a key that is no input (a possible sphere) stands for one of several, of which one is true.
    setup
        What says them.
    """
    stated = {one.key: one for one in uncertain_inputs(setup)}
    # what is called exact is moved by what a laboratory knows it to
    inputs = {key: one if one.u > 0.0 else replace(one, u=usual_u(one)) for key, one in stated.items()}
    places = np.array([_place(key) if key in inputs else "" for key in keys])
    if not any(places):
        return None
    cost, pull = _with_g(fit, responses, setup)
    own = np.array([float(keys.count(key)) for key in keys])
    own[[key in stated and stated[key].u == 0.0 for key in keys]] = _HELD
    _, bound = _least(cost, pull, own)
    gained: list[tuple[float, float, BoolArray, FloatArray]] = []
    for place in dict.fromkeys(one for one in places if one):
        freed = np.asarray(places == place)
        off, gain = _least(cost, pull, np.where(freed, _FREE, own))
        gained.append((gain - bound, _most_by_chance(int(freed.sum())), freed, off))
    gain, least, freed, off = max(gained, key=lambda one: one[0])
    bounds = np.array([_LEAST_OFF_EXACT if key in stated and stated[key].u == 0.0 else _LEAST_OFF for key in keys])
    if gain < least or not (np.abs(off) > bounds)[freed].any():
        return None
    found = {key: float(by) for key, by, one in zip(keys, off, freed, strict=True) if one}
    named, alike = str(places[freed][0]), gain - max(_ALIKE, _ALIKE_SHARE * gain)
    others = [str(places[which][0]) for other, _, which, _ in gained if other > alike and which is not freed]
    return SetupOutlier(found, _sentence(named, found, inputs, others))


def _place(key: str) -> str:
    """Return what an input belongs to; empty where it is told by g alone (wavelength)."""
    if key.startswith("radar."):
        return ""
    return key.split("[")[0] if key.startswith(("tracer.", "calibration")) else key.split(".")[0]


def _with_g(fit: FlightFit, responses: Sequence[InputResponse], setup: Setup) -> tuple[FloatArray, FloatArray]:
    """Return B and c of the flights and of g together."""
    cost, pull = fit.against(responses)
    site, density = gravity_of_site(setup.site), setup.tracer.density_kg_m3
    g, u = (_EARTH_M_S2, _U_EARTH_M_S2) if site is None else site[:2]
    off = fit.g_m_s2 - (g if density is None else share_in_air(density) * g)
    by_input = np.array([fit.follow(one)[0] for one in responses])
    weight = 1.0 / (u**2 + fit.u_g_m_s2**2)
    return cost + weight * np.outer(by_input, by_input), pull + weight * off * by_input


def _most_by_chance(degrees: int) -> float:
    """Return the chi-square that is exceeded once in ten thousand (Wilson & Hilferty, PNAS 17, 684, 1931)."""
    # by hand: loading `scipy.special` costs 0.1 s (decision 26)
    variance = 2.0 / (9.0 * degrees)
    return degrees * float(1.0 - variance + _SIGMAS * np.sqrt(variance)) ** 3


def _least(cost: FloatArray, pull: FloatArray, own: FloatArray) -> tuple[FloatArray, float]:
    """Return the deviations of least chi-square, and by how much they lessen it."""
    off: FloatArray = np.asarray(-np.linalg.solve(cost + np.diag(own), pull))
    return off, float(-pull @ off)


def _sentence(place: str, off: dict[str, float], inputs: dict[str, UncertainInput], others: list[str]) -> str:
    most = f"{max(abs(by) for by in off.values()):.0f} times what it is known to"
    if place == "calibration":
        likely = f"the antennas stand elsewhere than their calibration says ({most}): calibrate again"
    else:
        by = ", ".join(_by(inputs[key], one) for key, one in off.items() if abs(one) > _WORTH_NAMING)
        beside = f" (or {' or '.join(others)})" if others else ""
        if sum(one.startswith("receiver") for one in (place, *others)) > 1:
            beside = f"{beside[:-1]}, or receivers are exchanged)"
        likely = f"{place}{beside} is wrong, adding {by} would agree ({most}): measure it again"
    return f"{CONTRADICTED}: likely {likely}; the uncertainties count it as so far off"


def _by(one: UncertainInput, off: float) -> str:
    """Return what has to be added to an input, as "azimuth_deg -20" or "x +31 mm"."""
    value, is_angle = off * one.u, one.u_key.endswith("_deg")
    name = one.key.split(".")[-1]
    if one.key.startswith("tracer.release"):
        name = "xyz"[int(one.key[-2]) - 1]
    if abs(value) > (_FAR_DEG if is_angle else _FAR_M):
        return f"much to {name}"
    return f"{name} {value:+.2g}" if is_angle else f"{name} {1e3 * value:+.0f} mm"
