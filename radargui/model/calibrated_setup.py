"""Compare a setup with its calibration: values taken over, values edited since, its age, what changed."""

import math
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.calibration import Calibration, CalibrationContent, content_of
from radargui.model.finding import Finding, warn
from radargui.model.rounding import alone, plain as number, quantity
from radargui.model.setup import Setup, plain, validate_setup, with_calibration
from radargui.model.setup_error import flattened

AGREES = 0.1
"""Times its u: a value of the setup that differs by less was rounded; it makes u larger by half a percent at most."""
CORRELATED, KNOWN_TOGETHER = 0.5, 0.9
"""Correlations of two unknowns from which on the report lists them, and a sentence calls them known only together: each
alone has 1 / sqrt(1 - r^2) times the u that it would have if the other were known, 1.15 and 2.3 times (chosen by hand).
"""
_AXES = "xyz"
_KEY = re.compile(rf"(receiver|transmitter|tracer)\.(?:(\d+)\.)?(\w+)(?:\.([{_AXES}]))?")
"""Of a value in the setup: table, number, name and axis."""


def setup_key(name: str) -> str:
    """Return the key as in `model.assumed`: `receiver.1.tilt_deg` is receiver[1].tilt_deg, `.x` is [1]."""
    key = re.sub(r"^receiver\.(\d+)\.", r"receiver[\1].", name)
    return re.sub(r"(?<=_m)\.([xyz])$", lambda axis: f"[{_AXES.index(axis[1]) + 1}]", key)


def value_at(setup: Setup, name: str) -> float | None:
    """Return a setup's value at a key of a calibration; None if it has none."""
    value = dict(flattened(setup.model_dump(by_alias=True), every=True)).get(setup_key(name))
    return float(value) if isinstance(value, (int, float)) else None


def agreeing(setup: Setup) -> list[int]:
    """Return which values of its calibration the setup still has; none without a calibration."""
    content = setup.calibration.content
    return [] if content is None else [n for n in range(len(content.names)) if _agrees(setup, content, n)]


def _agrees(setup: Setup, content: CalibrationContent, n: int) -> bool:
    value = value_at(setup, content.names[n])
    # the spacing of doubles: a value that is exact has no u
    most = AGREES * math.sqrt(content.covariance[n][n]) + 1e-9
    return value is not None and abs(value - content.values[n]) <= most


def edited_since(setup: Setup) -> Finding | None:
    """Return which antennas' values are not those of the setup's calibration; None where all are."""
    content = setup.calibration.content
    if content is None:
        return None
    changed = tuple(
        f"{setup_key(name)} = {number(value_at(setup, name), 6)} (calibrated {number(content.values[n], 6)})"
        for n, name in enumerate(content.names)
        # of the antennas: a release is another for each drop
        if not _agrees(setup, content, n) and name.startswith(("receiver.", "transmitter."))
    )
    return warn("not_as_calibrated", day=day_of(content), changed=changed) if changed else None


def day_of(content: CalibrationContent) -> str:
    """Return the day a calibration was made, for people: 3 November 2025."""
    try:
        made = datetime.fromisoformat(content.made_at)
    except ValueError:
        return content.made_at
    return f"{made.day} {made:%B %Y}"


def calibration_words(setup: Setup) -> str:
    """Return what is said of the setup's calibration in a line; empty where it has none."""
    content = setup.calibration.content
    if content is None:
        return ""
    by = f" by {content.operator}" if content.operator else ""
    return f"calibration of {day_of(content)}{by}, {content.verdict}"


def too_old(setup: Setup, now: datetime) -> str:
    """Return a line if the calibration is older than the setup allows or its date cannot be read; else nothing.

    Parameters
    ----------
    setup
        With the age allowed.
    now
        Date and time with offset from UTC.
    """
    content, most = setup.calibration.content, setup.calibration.max_age_days
    if content is None:
        return ""
    try:
        made = datetime.fromisoformat(content.made_at)
    except ValueError:
        return f"the calibration has no date that can be read ({content.made_at}): its age is not known"
    age = (now - (made if made.tzinfo else made.astimezone())).total_seconds() / 86400.0
    if age <= most:
        return ""
    return f"the calibration of {day_of(content)} is {age:.0f} days old, more than calibration.max_age_days = {most:g}"


def calibrated(setup: Setup, calibration: Calibration, file: Path) -> Setup:
    """Return the setup with a calibration's values and uncertainties, referring to its file.

    Parameters
    ----------
    setup
        As it was; a transmitter that was found off the axis gets `position_m` instead of `distance_m`.
    calibration, file
        What was found, and where it is written.

    Raises
    ------
    SetupError
        A value that no setup can have.
    FileError
        The calibration's values do not fit together.
    """
    content, document = content_of(calibration), plain(setup)
    u = np.sqrt(np.diag(calibration.covariance))
    if "transmitter.position_m.x" in calibration.names:
        for key in ("distance_m", "phase_centre_m", "u_phase_centre_m"):
            document["transmitter"].pop(key, None)
        document["transmitter"]["position_m"] = list(setup.transmitter.place_m)
    for name, value, own_u in zip(calibration.names, calibration.values.tolist(), u.tolist(), strict=True):
        if not (found := _KEY.fullmatch(name)):
            continue
        head, index, key, axis = found.groups()
        table = document[head][int(index) - 1] if index else document.setdefault(head, {})
        if axis:
            # a release that is the default stands nowhere in the document
            table[key] = list(table.get(key) or getattr(getattr(setup, head), key))
            table[key][_AXES.index(axis)] = _rounded(value, own_u)
            key = "release_m" if head == "tracer" else "distance_m"
            # one u for three coordinates: the largest
            own_u = max(own_u, table.get(f"u_{key}") or 0.0) if axis != "x" else own_u
        else:
            table[key] = _rounded(value, own_u)
        table[f"u_{key}"] = float(f"{own_u:.3g}")
    return with_calibration(validate_setup(document, "the calibration's setup"), content, file)


def _rounded(value: float, u: float) -> float:
    """Return a value rounded to a hundredth of its u: fewer digits would not agree with the calibration any more."""
    return round(value, 2 - math.floor(math.log10(u))) if u > 0.0 else value


@dataclass(frozen=True, slots=True)
class Change:
    """One parameter in an older and a newer calibration.

    Attributes
    ----------
    name, unit
        Key, and what values are shown in.
    old, new
        Values with their u, as written for people.
    difference, in_u
        New less old, and the same in units of the combined u of both (independent); NaN where one has none.
    """

    name: str
    unit: str
    old: str
    new: str
    difference: str
    in_u: float


def unit_of(name: str) -> tuple[str, float]:
    """Return the unit that a parameter is shown in, and the factor to it."""
    return ("mm", 1e3) if "_m" in name else ("°", 1.0)


def changes_since(old: Calibration, new: Calibration) -> tuple[Change, ...]:
    """Return how the parameters that both calibrations have differ."""
    u_old, u_new = (np.sqrt(np.diag(one.covariance)) for one in (old, new))
    return tuple(
        change(name, (old.values[k], u_old[k]), (new.values[n], u_new[n]))
        for n, name in enumerate(new.names)
        if name in old.names
        for k in [old.names.index(name)]
    )


def change(name: str, old: tuple[float, float], new: tuple[float, float]) -> Change:
    """Return how a value with its u, NaN where not known, differs from another."""
    unit, scale = unit_of(name)
    difference, u = new[0] - old[0], math.hypot(old[1], new[1])
    old_text, new_text = (quantity(*own, scale=scale) for own in (old, new))
    difference_text = alone(difference, new[1], scale, signed=True)
    return Change(name, unit, old_text, new_text, difference_text, difference / u if u > 0.0 else math.nan)


def correlations(covariance: FloatArray, names: tuple[str, ...], least: float) -> list[tuple[str, str, float]]:
    """Return the pairs of names whose correlation is beyond `least` in size, with it, the largest first."""
    u = np.sqrt(np.diag(covariance))
    r = covariance / np.outer(u, u).clip(np.finfo(float).tiny)
    pairs = [(names[b], names[a], float(r[a, b])) for a in range(len(names)) for b in range(a) if abs(r[a, b]) > least]
    return sorted(pairs, key=lambda pair: -abs(pair[2]))
