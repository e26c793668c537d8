"""Which place of the setup is likely wrong by more than it says: flights and g against all of it (method 6)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.assumed import UncertainInput, uncertain_inputs, usual_u
from radargui.model.finding import Finding, warn
from radargui.model.setup import Setup
from radargui.restitution.setup_chi_square import SetupChiSquare

_SIGMAS = 3.72
"""A place gains so much by chance once in ten thousand: as many deviations of a normal number."""
_MIN_OFF, _MIN_OFF_EXACT = 5.0, 20.0
"""Deviation of an input, in its u, or of one that is called exact in what a laboratory knows it to: less is no mistake.
Where all are exact, what no model has (the walls of a box: 14) has nothing else to show in."""
_WORTH_NAMING = 3.0
"""The same, of what is named beside it."""
_ALIKE, _ALIKE_SHARE = 10.0, 0.3
"""Places whose gains in chi-square differ by less, or by less than this share of the best, cannot be told apart: two
receivers exchanged gained 81, 71, 61 and 61 as release or receiver."""
_FAR_DEG, _FAR_M = 45.0, 0.15
"""What is farther off is not told in numbers: the equations are linear, antennas and places are not."""
_OUTSIDE_M = 1.0
"""A release that would have to be farther off is in no field of view of some 0.3 m: nothing but the form has it there
(a sample rate of twice the true one: 46 m)."""
_MAX_LEFT = 0.1
"""Share of the flights' excess of chi-square that a wrong place leaves: what the linear answer misses of an angle off
by 0.4 rad is 0.2 of it, 0.04 in chi-square. Wrong places left 0.0 to 0.03, walls of a box 0.24 to 0.63
(two rooms)."""
_RELEASE = "tracer.release_position_m"


@dataclass(frozen=True, slots=True)
class SetupOutlier:
    """A place that is likely wrong.

    Attributes
    ----------
    off
        What has to be added to each of its inputs, in their u, by key.
    finding
        Which place, and whether it makes the flights agree. Where it does not something else bends them, too.
    """

    off: dict[str, float]
    finding: Finding


def setup_outlier(chi_square: SetupChiSquare, keys: Sequence[str], setup: Setup) -> SetupOutlier | None:
    """Return the place without whose u flights and g agree far better, all else within its u; None without one.

    The least chi-square over all deviations, less that without the own squares of the inputs of one place, is
    chi-square distributed with as many degrees of freedom, if the setup is right.

    Parameters
    ----------
    chi_square
        Of flights, g and inputs.
    keys
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
    _, bound = chi_square.least()
    gained: list[tuple[float, float, BoolArray, FloatArray]] = []
    for place in dict.fromkeys(one for one in places if one):
        freed = np.asarray(places == place)
        off, gain = chi_square.least(freed)
        by_m = [abs(by) * inputs[key].u for key, by in zip(keys, off, strict=True) if key.startswith(_RELEASE)]
        if place == _RELEASE and max(by_m) > _OUTSIDE_M:
            continue
        gained.append((gain - bound, _max_by_chance(int(freed.sum())), freed, off))
    if not gained:
        return None
    gain, least, freed, off = max(gained, key=lambda one: one[0])
    bounds = np.array([_MIN_OFF_EXACT if key in stated and stated[key].u == 0.0 else _MIN_OFF for key in keys])
    if gain < least or not (np.abs(off) > bounds)[freed].any():
        return None
    found = {key: float(by) for key, by, one in zip(keys, off, freed, strict=True) if one}
    named, alike = str(places[freed][0]), gain - max(_ALIKE, _ALIKE_SHARE * gain)
    others = [str(places[which][0]) for other, _, which, _ in gained if other > alike and which is not freed]
    left = chi_square.share_left(bound + gain)
    return SetupOutlier(found, _finding(named, found, inputs, others, float(left)))


def wrong_value(key: str, by: float, gain: float, left: float, setup: Setup) -> Finding | None:
    """Return the finding that one value is wrong, which was tried by estimates of their own; None where it is not.

    Parameters
    ----------
    key, by
        Which value, and what has to be added to it.
    gain, left
        By how much chi-square is less then, and the share of what the signals leave beyond noise that stays.
    setup
        What states it.
    """
    one = next(one for one in uncertain_inputs(setup) if one.key == key)
    stated = one if one.u > 0.0 else replace(one, u=usual_u(one))
    off, min_off = by / stated.u, _MIN_OFF if one.u > 0.0 else _MIN_OFF_EXACT
    if gain < _max_by_chance(1) or abs(off) < min_off or not left < _MAX_LEFT:
        return None
    found = _finding(key, {key: off}, {key: stated}, [], left)
    # its uncertainties are those with the value that is stated
    return found.with_facts(is_counted=False)


def _place(key: str) -> str:
    """Return what an input belongs to; empty where it is told by g alone (wavelength)."""
    if key.startswith("radar."):
        return ""
    return key.split("[")[0] if key.startswith(("tracer.", "calibration")) else key.split(".")[0]


def _max_by_chance(degrees: int) -> float:
    """Return the chi-square that is exceeded once in ten thousand (Wilson & Hilferty, PNAS 17, 684, 1931)."""
    # by hand: loading `scipy.special` costs 0.1 s (decision 26)
    variance = 2.0 / (9.0 * degrees)
    return degrees * float(1.0 - variance + _SIGMAS * np.sqrt(variance)) ** 3


def _finding(
    place: str, off: dict[str, float], inputs: dict[str, UncertainInput], others: list[str], left: float
) -> Finding:
    may_be_exchanged = sum(one.startswith("receiver") for one in (place, *others)) > 1
    kind = "calibration" if place == "calibration" else "place"
    return warn(
        "setup_contradicted",
        explains=bool(left < _MAX_LEFT),
        is_counted=True,
        what=kind,
        what_in_part=kind,
        place=place,
        beside="exchanged" if may_be_exchanged else "others" if others else "",
        others=" or ".join(others),
        or_else=_or_else(place, off),
        adding=tuple(_by(inputs[key], one) for key, one in off.items() if abs(one) > _WORTH_NAMING),
        times_u=max(abs(by) for by in off.values()),
        left=left,
    )


def _or_else(place: str, off: dict[str, float]) -> str:
    """Return what a laboratory may have that moves the same value: a holder beside the rest, a horn near by."""
    if place.startswith("tracer.release"):
        return "holder"
    is_antenna = place.startswith(("receiver", "transmitter"))
    return "horn" if is_antenna and any(key.endswith("distance_m") for key in off) else ""


def _by(one: UncertainInput, off: float) -> str:
    """Return what has to be added to an input, as "azimuth_deg -20" or "x +31 mm"."""
    value, is_angle = off * one.u, one.u_key.endswith("_deg")
    name = one.key.split(".")[-1]
    if one.key.startswith("tracer.release"):
        name = "xyz"[int(one.key[-2]) - 1]
    if abs(value) > (_FAR_DEG if is_angle else _FAR_M):
        return f"much to {name}"
    return f"{name} {value:+.2g}" if is_angle else f"{name} {1e3 * value:+.0f} mm"
