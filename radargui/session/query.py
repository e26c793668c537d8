"""What sessions are looked for by."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from datetime import date

from radargui.model.setup import Setup

_ANTENNAS = ("radar", "transmitter", "receiver")


@dataclass(frozen=True, slots=True)
class Query:
    """All that is given must hold; upper and lower case are the same.

    Attributes
    ----------
    since, until
        First and last day, as the clock of the recording computer showed it.
    operator, sample
        A part of what the record says; the sample is looked for in the target too.
    setup_name
        A part of the setup's name.
    antennas
        A setup: the session was recorded with the same antennas, frequency and sign.
    e_min, e_max
        A run that counts has a first bounce with e within.
    text
        Words that all stand in notes, journal, names, markers of runs or reasons of rejection.
    """

    since: date | None = None
    until: date | None = None
    operator: str = ""
    sample: str = ""
    setup_name: str = ""
    antennas: Setup | None = None
    e_min: float | None = None
    e_max: float | None = None
    text: str = ""


def antenna_key(setup: Setup) -> str:
    """Return a short text that two setups share where their antennas, frequency and sign are the same."""
    content = {name: setup.model_dump(mode="json")[name] for name in _ANTENNAS}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:24]
