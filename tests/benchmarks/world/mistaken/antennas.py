"""Mistakes about where the antennas are and how they are turned."""

from __future__ import annotations

import numpy as np
from benchmarks.world.mistaken.sheet import Sheet

INCH_M, FOOT_M = 0.0254, 0.3048


def receivers(sheet: Sheet, variant: str) -> None:
    """Two `exchanged`, all three `rotated`, or one exchanged with the `transmitter`."""
    first, second, third = sheet.chosen
    all_ = list(sheet.receivers)
    if variant == "exchanged":
        all_[first], all_[second] = all_[second], all_[first]
    elif variant == "rotated":
        all_[first], all_[second], all_[third] = all_[second], all_[third], all_[first]
    else:
        sender, one = sheet.tables["transmitter"], sheet.one
        tilt, azimuth = np.radians(one["tilt_deg"]), np.radians(one["azimuth_deg"])
        way = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        place = tuple((one["distance_m"] * way).tolist())
        all_[first] = {**one, "tilt_deg": 0.0, "azimuth_deg": 0.0, "distance_m": sender["distance_m"]}
        sheet.tables["transmitter"] = {
            **{key: value for key, value in sender.items() if key != "distance_m"}, "position_m": place,
        }  # fmt: skip
    sheet.tables["receiver"] = tuple(all_)


def azimuth(sheet: Sheet, variant: str) -> None:
    """One `mirrored`, all `clockwise`, `one` off by 3 to 30 degrees, all `turned` by as much together."""
    if variant == "mirrored":
        sheet.one["azimuth_deg"] = -sheet.one["azimuth_deg"]
    elif variant == "clockwise":
        for one in sheet.receivers:
            one["azimuth_deg"] = -one["azimuth_deg"]
    else:
        off = sheet.off(3.0, 30.0)
        for one in [sheet.one] if variant == "one" else sheet.receivers:
            one["azimuth_deg"] = (one["azimuth_deg"] + off) % 360.0


def tilt(sheet: Sheet, variant: str) -> None:
    """`one` off by 3 to 30 degrees, all from the `horizon`, in `radians`, or from `below`."""
    if variant == "one":
        sheet.one["tilt_deg"] = abs(sheet.one["tilt_deg"] + sheet.off(3.0, 30.0))
        return
    for one in sheet.receivers:
        told = one["tilt_deg"]
        one["tilt_deg"] = {"horizon": 90.0 - told, "radians": float(np.radians(told)), "below": 180.0 - told}[variant]


def distance(sheet: Sheet, variant: str) -> None:
    """One `receiver`, the `transmitter` off by 1 to 7 cm, `all` by 1 to 10 %, or in another unit."""
    sender = sheet.tables["transmitter"]
    if variant in ("receiver", "transmitter"):
        (sheet.one if variant == "receiver" else sender)["distance_m"] += sheet.off(0.01, 0.07)
        return
    factor = {"centimetres": 100.0, "inches": 1.0 / INCH_M, "feet": 1.0 / FOOT_M}.get(variant)
    factor = factor or 1.0 + sheet.off(0.01, 0.1)
    for one in (sender, *sheet.receivers):
        one["distance_m"] *= factor


def polarization(sheet: Sheet, variant: str) -> None:
    """`all`, one `receiver` or the `transmitter` turned by 90 degrees; `left-out`."""
    sender = sheet.tables["transmitter"]
    told = {"receiver": [sheet.one], "transmitter": [sender]}.get(variant, [sender, *sheet.receivers])
    for one in told:
        if variant == "left-out":
            one.pop("polarization_deg"), one.pop("u_polarization_deg")
        else:
            one["polarization_deg"] = (one["polarization_deg"] + 90.0) % 180.0


def count(sheet: Sheet, variant: str) -> None:
    """One receiver `forgotten` in the setup, `absent` in the file too, `imagined`, or there twice, a `copy`."""
    kept = sorted(sheet.chosen[1:])
    if variant in ("forgotten", "absent"):
        sheet.tables["receiver"] = tuple(sheet.receivers[k] for k in kept)
    else:
        sheet.tables["receiver"] = (*sheet.receivers, dict(sheet.one))
    if variant in ("absent", "copy"):
        wires = kept if variant == "absent" else [*sorted(sheet.chosen), sheet.chosen[0]]
        sheet.rewire([2 * k + part for k in wires for part in range(2)])
