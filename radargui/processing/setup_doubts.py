"""What speaks against a setup: values that no laboratory has, falls upwards, a g unknown on Earth, another floor."""

import math
from collections.abc import Sequence

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.conditioning.fall_signs import fall_signs
from radargui.model.gravity import EARTH_GRAVITY_M_S2, NOMINAL_GRAVITY_M_S2, gravity_of_site, share_in_air
from radargui.model.recording import Digitisation
from radargui.model.result import Bounces, Track
from radargui.model.rounding import concise, plain
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget

_FARTHEST_M = 10.0
"""From an antenna to the field of view of some 0.3 m: from farther no sphere of some mm is seen, and a laboratory's
0.5 to 1 m told in centimetres, millimetres or inches lie there."""
_LEAST_TILT_DEG = 2.0
"""A laboratory's 30 to 60 degrees are 0.5 to 1.05 in radians; receivers that all stand so close to the z axis tell no
place."""
_THINNEST_AIR = 1.0001
"""n of dry air at 5000 m and 40 degrees C is 1.00013 (ITU-R P.453)."""
_LIGHTEST_KG_M3 = 1000.0
"""Of a sphere of which no density is given: air may take 0.18 % off its acceleration, or nothing."""
_SIGMAS = 3.0
"""How far beyond what is possible a measured value has to be, in its own u."""
_U_FLOOR_M = 3e-3
"""Of a floor's height measured by tape, as of antennas: the setup has no u for it."""


def unlikely(setup: Setup) -> list[str]:
    """Return a sentence for each kind of value that no laboratory has."""
    others = (_vacuum(setup), _floor_upside_down(setup), _floor_above(setup))
    return [*misplaced(setup), *(one for one in others if one)]


def misplaced(setup: Setup) -> list[str]:
    """Return those of antennas that stand where none does: flights bend by them, and would name any place for it."""
    return [one for one in (_far_antenna(setup), _angles_in_radians(setup)) if one]


def _far_antenna(setup: Setup) -> str:
    antennas = {"transmitter": setup.transmitter.distance_m}
    antennas |= {f"receiver[{n}]": one.distance_m for n, one in enumerate(setup.receiver, 1)}
    far = [name for name, distance_m in antennas.items() if distance_m is not None and distance_m > _FARTHEST_M]
    if not far:
        return ""
    return (
        f"{far[0]}.distance_m = {antennas[far[0]]:g}: from there no echo of a small sphere is seen, and places "
        "and e are wrong if the antenna is nearer: give metres, from the centre of the field of view"
    )


def _angles_in_radians(setup: Setup) -> str:
    tilts = [one.tilt_deg for one in setup.receiver]
    if len(tilts) < 2 or not 0.0 < max(tilts) < _LEAST_TILT_DEG:
        return ""
    given = ", ".join(f"{tilt:.3g}" for tilt in tilts)
    return (
        f"the receivers' tilt_deg are {given}, all next to the z axis: if these are radians, give degrees "
        f"({math.degrees(tilts[0]):.3g} for {tilts[0]:.3g}), of the azimuths too"
    )


def _vacuum(setup: Setup) -> str:
    index = setup.radar.refractive_index
    # left out it is uncertain by what air has
    if index is None or index >= _THINNEST_AIR:
        return ""
    return (
        f"radar.refractive_index = {index:g} is that of a vacuum, where air has 1.0003: lengths and g come out 0.03 % "
        "too large: give that of the air, or leave it out, and the uncertainties hold it"
    )


def _floor_upside_down(setup: Setup) -> str:
    if setup.floor.normal[2] >= 0.0:
        return ""
    return "floor.normal points down: give the direction away from the floor, towards the sphere above it"


def _floor_above(setup: Setup) -> str:
    floor_m, release_m = setup.floor.height_m, setup.tracer.release_position_m[2]
    # a release that was left out is told already
    if floor_m is None or floor_m < release_m or "release_position_m" not in setup.tracer.model_fields_set:
        return ""
    return (
        f"floor.height_m = {floor_m:g} is not below tracer.release_position_m, z = {release_m:g}: give both for the "
        "sphere's centre, from the centre of the field of view, z up"
    )


def without_room(conditioned: Conditioned, digitisation: Digitisation) -> list[str]:
    """Return what is said of delays between channels for which a sample has no room, if they are such."""
    n_channels, rate_hz = conditioned.delay_s.size, digitisation.sample_rate_hz
    # a multiplexer is through with a sample before the next one begins
    if conditioned.delay_s[-1] * rate_hz < 1.0:
        return []
    apart, room = f"{1e6 * conditioned.delay_s[1]:g} µs apart", f"{1e6 / rate_hz:.3g} µs"
    return [f"{n_channels} channels {apart} do not fit into a sample of {room}: correct daq.channel_skew_s"]


def wired_wrongly(conditioned: Conditioned, setup: Setup) -> tuple[tuple[str, ...], str]:
    """Return why a receiver is none, one a receiver, with the faults found before; and a sentence about the clock.

    In a fall that all receivers show none may show that the sphere falls upwards: refused before anything is measured,
    for three receivers of which one is turned round may still find a motion that fits them.
    """
    signs = fall_signs(conditioned, setup)
    if all(signs.backwards):
        sign = -setup.radar.phase_sign
        first = (
            "all phases turn as if the sphere fell upwards: set radar.phase_sign to "
            f"{sign}, or exchange I and Q of every receiver"
        )
        return (first, *["the same"] * (conditioned.n_receivers - 1)), ""
    turned = (
        "its phase turns as if the sphere fell upwards, the others' as it falls: its I and Q are exchanged, or one of "
        "them is inverted: exchange the two cables, or their names"
    )
    clock = ""
    if signs.times_g is not None:
        clock = (
            f"all phases turn with {signs.times_g:.2g} times the acceleration of a fall: likely the sample rate is "
            f"wrong by a factor of {math.sqrt(signs.times_g):.1g}, or radar.frequency_hz is"
        )
    found = zip(conditioned.faults, signs.backwards, strict=True)
    return tuple(fault or (turned if is_turned else "") for fault, is_turned in found), clock


def contradicted(
    setup: Setup, rate_hz: float, track: Track, bounces: Bounces, budget: UncertaintyBudget | None
) -> list[str]:
    """Return sentences where the fall, or the floor that was met, contradicts the setup by more than it says.

    Parameters
    ----------
    setup
        What was stated.
    rate_hz
        At which the samples were counted.
    track, bounces, budget
        As measured with it; None where nothing is known of what the setup does to it.
    """
    # the far field makes g wrong by percents, and says so
    if track.geometry != "exact" or budget is None:
        return []
    doubts = (_impossible_g(setup, rate_hz, bounces, budget), _floor_elsewhere(setup, track, bounces))
    return [one for one in doubts if one]


def _impossible_g(setup: Setup, rate_hz: float, bounces: Bounces, budget: UncertaintyBudget) -> str:
    fall, combined = bounces.free_fall, budget.g_m_s2.combined
    # what is thrown upwards does not fall (NaN neither)
    if fall is None or not fall.g_m_s2 > 0.0:
        return ""
    u = fall.u_g_m_s2 if combined is None else combined
    least, most = possible_g_m_s2(setup)
    # NaN compares false: what is not known contradicts nothing
    if not max(least - fall.g_m_s2, fall.g_m_s2 - most) > _SIGMAS * u:
        return ""
    site = gravity_of_site(setup.site)
    there = NOMINAL_GRAVITY_M_S2 if site is None else site[0]
    known = "on Earth it is 9.76 to 9.84" if site is None else f"the site has {plain(there, 5)}"
    # lengths go with 1 / frequency, times with 1 / rate
    ratio = fall.g_m_s2 / there
    rate_hz, frequency_hz = rate_hz / math.sqrt(ratio), ratio * setup.radar.frequency_hz
    return (
        f"g came out as {concise(fall.g_m_s2, u)} m/s², and {known}: likely the setup is wrong by more than it says, "
        "and the track with it, or something reflects that is not in the model. Check the sample rate (it would have "
        f"to be {plain(rate_hz, 4, 'Hz')}), radar.frequency_hz (or {plain(frequency_hz, 4, 'GHz', 1e-9)}), "
        "tracer.release_position_m, tilts and distances of the antennas"
    )


def possible_g_m_s2(setup: Setup) -> tuple[float, float]:
    """Return the least and the most that the sphere may fall with at the setup's site, or anywhere on Earth, m/s^2."""
    density, site = setup.tracer.density_kg_m3, gravity_of_site(setup.site)
    least, most = EARTH_GRAVITY_M_S2 if site is None else (site[0] - _SIGMAS * site[1], site[0] + _SIGMAS * site[1])
    lightest = share_in_air(_LIGHTEST_KG_M3 if density is None else density)
    return lightest * least, most if density is None else lightest * most


def _floor_elsewhere(setup: Setup, track: Track, bounces: Bounces) -> str:
    stated_m = setup.floor.height_m
    if stated_m is None:
        return ""
    met = _touch_m(track, [one.time_s for one in bounces.impacts if one.valid], setup.floor.normal, stated_m)
    if met is None:
        return ""
    height_m, u_m = met
    if not abs(height_m - stated_m) > _SIGMAS * math.hypot(u_m, _U_FLOOR_M):
        return ""
    x, y, _ = setup.floor.normal
    where = "" if x == y == 0.0 else " on the z axis"
    return (
        f"the sphere touched the floor with its centre at z = {1e3 * height_m:.0f} mm{where}, and floor.height_m says "
        f"{1e3 * stated_m:.0f} mm: one of floor.height_m and tracer.release_position_m is wrong, and the whole track "
        "where that is the release: measure both from the centre of the field of view to the sphere's centre"
    )


def _touch_m(
    track: Track, times_s: Sequence[float], normal: tuple[float, float, float], stated_m: float
) -> tuple[float, float] | None:
    """Return the height on the z axis of the floor touched at some instants, and its u; None without any.

    Of several floors, a plate and the table below it, the one next to what the setup says: that it speaks of one of
    them is no contradiction.
    """
    if not times_s or normal[2] <= 0.0:
        return None
    # the next sample is less than a millimetre away: a tape tells no less
    place = np.minimum(np.searchsorted(track.time_s, times_s), track.time_s.size - 1)
    place = place[track.valid[place] & np.isfinite(track.position_m[:, place]).all(axis=0)]
    if not place.size:
        return None
    u_m = track.u_position_m if track.u_combined_m is None else track.u_combined_m
    # a plane that leans is met higher or lower away from the axis
    height_m = np.asarray(normal) @ track.position_m[:, place] / normal[2]
    nearest = int(np.argmin(np.abs(height_m - stated_m)))
    return float(height_m[nearest]), float(u_m[2, place[nearest]])
