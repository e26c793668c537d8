"""Mistakes about wires, clock and wave."""

from __future__ import annotations

from benchmarks.world.mistaken.sheet import Sheet


def wires(sheet: Sheet, variant: str) -> None:
    """Channels under each other's names.

    Both of two `antennas`, I and Q of one receiver (a `pair`), Q of one and I of the `next`, all `shifted` by one; one
    `inverted`; all volts `half`.
    """
    n = 2 * sheet.case.n_receivers
    order, sizes = list(range(n)), [1.0] * n
    first, second = sheet.chosen[:2]
    if variant == "antennas":
        for part in range(2):
            order[2 * first + part], order[2 * second + part] = 2 * second + part, 2 * first + part
    elif variant == "pair":
        order[2 * first : 2 * first + 2] = 2 * first + 1, 2 * first
    elif variant == "next":
        at = 2 * min(first, n // 2 - 2) + 1
        order[at : at + 2] = at + 1, at
    elif variant == "shifted":
        order = [*order[1:], order[0]]
    elif variant == "inverted":
        sizes[2 * first + int(sheet.case.rng.integers(2))] = -1.0
    else:
        sizes = [0.5] * n
    sheet.rewire(order, sizes)


def sign(sheet: Sheet, variant: str) -> None:
    """Phase sign of the other `wiring`."""
    del variant
    sheet.tables["radar"]["phase_sign"] *= -1


def frequency(sheet: Sheet, variant: str) -> None:
    """Of the wave: `off` by 0.2 to 5 %."""
    del variant
    sheet.tables["radar"]["frequency_hz"] *= 1.0 + sheet.off(0.002, 0.05)


def air(sheet: Sheet, variant: str) -> None:
    """Of no refraction: a `vacuum`."""
    del variant
    sheet.tables["radar"]["refractive_index"] = 1.0


def clock(sheet: Sheet, variant: str) -> None:
    """Sample rate `off` by 0.1 to 2 %, `half` of the true one, `double`."""
    factor = {"half": 0.5, "double": 2.0}.get(variant)
    sheet.tables["daq"]["rate_hz"] *= factor or 1.0 + sheet.off(0.001, 0.02)


def skew(sheet: Sheet, variant: str) -> None:
    """In the setup alone: `none`, `double`, or as if the channels were spread over the `sample`."""
    daq = sheet.tables["daq"]
    n, told = 2 * sheet.case.n_receivers, daq["channel_skew_s"]
    daq["channel_skew_s"] = {"none": 0.0, "double": 2.0 * told, "sample": 1.0 / (n * daq["rate_hz"])}[variant]
    sheet.skew_in_file = False
