"""Which place of the setup is likely wrong by more than it says: flights and g against all its inputs at once."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.assumed import UncertainInput, uncertain_inputs, usual_u
from radargui.model.setup import Setup
from radargui.restitution.bent_flights import CONTRADICTED, COUNTED, NAMED
from radargui.restitution.setup_chi_square import SetupChiSquare

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
_OUTSIDE_M = 1.0
"""A release that would have to be farther off is in no field of view of some 0.3 m: nothing but the form has it there
(a sample rate of twice the true one: 46 m)."""
_MOST_LEFT = 0.1
"""Share of the flights' excess of chi-square that a wrong place leaves: what the linear answer misses of an angle off
by 0.4 rad is 0.2 of it, 0.04 in chi-square. Wrong places left 0.0 to 0.03, walls of a box 0.24 to 0.63 (laboratory
7047241, 770535)."""
_AGREES = 0.5
"""Deviations of chi-square above its mean up to which flights agree with a place: of six right setups in which one was
named azimuths 6 to 74 degrees off left 1.3 to 9, wrong distances in as loud drops -1.2 and -0.1 (decision 51)."""
_RELEASE = "tracer.release_position_m"
_SLIPS = 0.01
"""Share of places, and of values, that people misstate: chosen by hand."""


@dataclass(frozen=True, slots=True)
class SetupOutlier:
    """A place that is likely wrong.

    Attributes
    ----------
    off
        What has to be added to each of its inputs, in their u, by key.
    sentence
        For people.
    explains
        Whether it makes the flights agree. Where it does not something else bends them, too.
    """

    off: dict[str, float]
    sentence: str
    explains: bool = True

    def widening(self, key: str) -> float:
        """Return by how many u an input counts as uncertain: as far off as the run itself says."""
        return max(1.0, abs(self.off.get(key, 0.0)))


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
        gained.append((gain - bound, _most_by_chance(int(freed.sum())), freed, off))
    if not gained:
        return None
    gain, least, freed, off = max(gained, key=lambda one: one[0])
    bounds = np.array([_LEAST_OFF_EXACT if key in stated and stated[key].u == 0.0 else _LEAST_OFF for key in keys])
    if gain < least or not (np.abs(off) > bounds)[freed].any():
        return None
    # what the linear answer misses goes into azimuths, which a fall hardly shows, but makes flights agree with none
    is_antenna = places[freed][0] != _RELEASE
    if is_antenna and gain < chi_square.blur * least and chi_square.sigmas_left(bound + gain) > _AGREES:
        return None
    found = {key: float(by) for key, by, one in zip(keys, off, freed, strict=True) if one}
    named, alike = str(places[freed][0]), gain - max(_ALIKE, _ALIKE_SHARE * gain)
    others = [str(places[which][0]) for other, _, which, _ in gained if other > alike and which is not freed]
    left = chi_square.share_left(bound + gain)
    return SetupOutlier(found, _sentence(named, found, inputs, others, left), bool(left < _MOST_LEFT))


def misstated(chi_square: SetupChiSquare, keys: Sequence[str], setup: Setup) -> FloatArray:
    """Return by how many u inputs count as uncertain since one place may be misstated, shape (n,).

    Too weakly for `setup_outlier` to name it: a release 17 mm beside the truth bends flights as angles that are off by
    two of their u do. The setup as it is, each place and each of its values misstated are mixed by their evidence, as
    alternatives are (method 6). What the setup calls exact stays so.
    """
    stated = {one.key: one.u for one in uncertain_inputs(setup)}
    places = np.array([_place(key) if stated.get(key, 0.0) > 0.0 else "" for key in keys])
    wholes = [np.asarray(places == place) for place in dict.fromkeys(one for one in places if one)]
    # one number is misread more easily than three, and the flights have to say less of it
    alone = [np.arange(len(keys)) == n for whole in wholes if whole.sum() > 1 for n in np.flatnonzero(whole)]
    # the setup as it is first
    logs, squares = [0.0], [np.ones(len(keys))]
    for which in (*wholes, *alone):
        square, evidence = chi_square.misstated(which)
        logs.append(np.log(_SLIPS) + evidence)
        squares.append(np.where(which, np.maximum(1.0, square), 1.0))
    weights = np.exp(np.array(logs) - max(logs))
    return np.asarray(np.sqrt(weights @ np.array(squares) / weights.sum()))


def _place(key: str) -> str:
    """Return what an input belongs to; empty where it is told by g alone (wavelength)."""
    if key.startswith("radar."):
        return ""
    return key.split("[")[0] if key.startswith(("tracer.", "calibration")) else key.split(".")[0]


def _most_by_chance(degrees: int) -> float:
    """Return the chi-square that is exceeded once in ten thousand (Wilson & Hilferty, PNAS 17, 684, 1931)."""
    # by hand: loading `scipy.special` costs 0.1 s (decision 26)
    variance = 2.0 / (9.0 * degrees)
    return degrees * float(1.0 - variance + _SIGMAS * np.sqrt(variance)) ** 3


def _sentence(
    place: str, off: dict[str, float], inputs: dict[str, UncertainInput], others: list[str], left: float
) -> str:
    most = f"{max(abs(by) for by in off.values()):.0f} times what it is known to"
    by = ", ".join(_by(inputs[key], one) for key, one in off.items() if abs(one) > _WORTH_NAMING)
    beside = f" (or {' or '.join(others)})" if others else ""
    if sum(one.startswith("receiver") for one in (place, *others)) > 1:
        beside = f"{beside[:-1]}, or receivers are exchanged)"
    if not left < _MOST_LEFT:
        what = "the calibration" if place == "calibration" else f"{place}{beside}, adding {by},"
        return (
            f"{CONTRADICTED}, and nothing in it alone explains that: {what} leaves {left:.0%} of it ({most}){COUNTED}"
        )
    if place == "calibration":
        likely = f"the antennas stand elsewhere than their calibration says ({most}): calibrate again"
    else:
        likely = f"{place}{beside} is wrong, adding {by} would agree ({most}): measure it again"
    return f"{NAMED} {likely}{COUNTED}"


def _by(one: UncertainInput, off: float) -> str:
    """Return what has to be added to an input, as "azimuth_deg -20" or "x +31 mm"."""
    value, is_angle = off * one.u, one.u_key.endswith("_deg")
    name = one.key.split(".")[-1]
    if one.key.startswith("tracer.release"):
        name = "xyz"[int(one.key[-2]) - 1]
    if abs(value) > (_FAR_DEG if is_angle else _FAR_M):
        return f"much to {name}"
    return f"{name} {value:+.2g}" if is_angle else f"{name} {1e3 * value:+.0f} mm"
