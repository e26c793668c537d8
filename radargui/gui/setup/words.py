"""The setup in the operator's words: what each value is called, in which unit it is shown, what is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pydantic import ValidationError

from radargui.model.setup import Setup
from radargui.model.setup_error import describe, dotted, faults_in_order, find_place

_KEY = re.compile(r"\b[a-z]+(?:\[\d+\])?\.[a-z_0-9]+(?:\[\d+\])?")


def parse_number(text: str, scale: float = 1.0) -> float | str | None:
    """Return the number that a text means, the text itself where it means none, None where it is empty.

    A decimal comma is understood. `scale` is shown value per stored value.
    """
    cleaned = text.strip().replace("\u2212", "-")
    if not cleaned:
        return None
    try:
        value = float(cleaned.replace(",", ".") if cleaned.count(",") == 1 and "." not in cleaned else cleaned)
    except ValueError:
        return cleaned
    return float(f"{value / scale:.12g}")


def show_number(value: object, scale: float = 1.0) -> str:
    """Return a stored number as the operator reads it."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "" if value is None else str(value)
    return f"{value * scale:.10g}"


@dataclass(frozen=True, slots=True)
class Words:
    """What a value of the setup is called beside its field.

    Attributes
    ----------
    name, unit
        As written: `Tilt`, `°`.
    scale
        Shown value per stored value: 1000 for a metre shown in mm.
    tip
        What it means.
    choices
        What may be chosen, stored value to words; empty where it is typed.
    """

    name: str
    unit: str = ""
    scale: float = 1.0
    tip: str = ""
    choices: Mapping[Any, str] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """Name and unit as they stand beside the field."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    def shown(self, value: object) -> str:
        """Return a stored value as the field shows it."""
        if isinstance(value, (list, tuple)):
            return ", ".join(show_number(one, self.scale) for one in value)
        if isinstance(value, bool):
            return "yes" if value else "no"
        return self.choices.get(value) or show_number(value, self.scale)

    def with_unit(self, value: object) -> str:
        """Return a stored value with its unit; `not set` where there is none."""
        return " ".join(filter(None, (self.shown(value), self.unit))) if value is not None else "not set"


CORRECTIONS = {
    "joint": "Joint fit",
    "adaptive": "Adaptive",
    "published": "Published (peaks and valleys)",
    "ellipse": "Static ellipse (Heydemann)",
    "none": "None",
}
GEOMETRIES = {"exact": "Exact (near field)", "plane": "Plane wave (far field)"}
_TERMINALS = {
    "differential": "Differential",
    "rse": "Referenced single-ended (RSE)",
    "nrse": "Non-referenced single-ended (NRSE)",
    "pseudodifferential": "Pseudodifferential",
    "default": "Default of the device",
}
_SCENES = {
    "drop": "Free fall with bounces",
    "circle": "Circle",
    "pendulum": "Pendulum",
    "bed": "Stop in a granular bed",
    "rest": "At rest",
}
_WORDS = {
    "radar.frequency_hz": Words("Frequency", "GHz", 1e-9),
    "radar.phase_sign": Words(
        "Phase sign",
        tip="Moving the tracer away must raise every path length",
        choices={1: "+1 (I = A cos, Q = A sin)", -1: "−1 (Q inverted)"},
    ),
    "radar.refractive_index": Words(
        "Refractive index", tip="Of the air: wavelength = c / (n f). 1.00032 in a laboratory; empty: vacuum"
    ),
    "transmitter.position_m": Words("Position x, y, z", "mm", 1e3, "Where a calibration found the transmitter"),
    "transmitter.polarization_deg": Words(
        "Polarisation",
        "°",
        tip="Direction of the electric field, from the x axis towards the y axis; empty: the sphere counts as a point",
    ),
    "transmitter.u_polarization_deg": Words("Uncertainty ±", "°", tip="Standard uncertainty of the angle"),
    "receiver.polarization_deg": Words(
        "Polarisation",
        "°",
        tip="Of the field it answers to, from the horizontal h towards v; empty: turned for the strongest signal",
    ),
    "receiver.u_polarization_deg": Words("Uncertainty ±", "°", tip="Standard uncertainty of the angle"),
    "transmitter.distance_m": Words("Distance", "mm", 1e3, "From the centre of the field of view, on the z axis"),
    "receiver.tilt_deg": Words("Tilt", "°"),
    "receiver.azimuth_deg": Words("Azimuth", "°"),
    "receiver.distance_m": Words("Distance", "mm", 1e3),
    "tracer.diameter_m": Words("Diameter", "mm", 1e3),
    "tracer.u_diameter_m": Words("Diameter ±", "mm", 1e3, "Standard uncertainty of the diameter"),
    "tracer.density_kg_m3": Words("Density", "kg/m³", tip="For the buoyancy in air when g is checked; steel 7800"),
    "tracer.release_position_m": Words(
        "Release x, y, z", "mm", 1e3, "Centre of the sphere where it hangs before the fall"
    ),
    "floor.height_m": Words(
        "Floor z", "mm", 1e3, "Centre of the sphere where it touches; empty: found from the impacts"
    ),
    "site.latitude_deg": Words("Latitude", "°", tip="With the height: normal gravity of the place, for the check of g"),
    "site.height_m": Words("Height above the sea", "m"),
    "site.g_m_s2": Words("or g", "m/s²", tip="Where it is known better than from latitude and height"),
    "site.u_g_m_s2": Words("g ±", "m/s²", tip="Standard uncertainty; empty: 0.0005 m/s²"),
    "daq.device": Words("Device", tip="Name in NI-DAQmx, for instance Dev1"),
    "daq.remote": Words(
        "Device server", tip="host:port of an NI gRPC device server; empty: the driver of this computer"
    ),
    "daq.remote_certificate": Words(
        "Certificate", tip="File (PEM) that a device server with encryption (TLS) is known by; empty: no encryption"
    ),
    "daq.channels": Words("Channels", tip="In the order I1, Q1, I2, Q2, …; empty: ai0, ai1, …"),
    "daq.terminal": Words("Terminal", choices=_TERMINALS),
    "daq.range_v": Words("Range ±", "V"),
    "daq.channel_skew_s": Words(
        "Channel skew", "µs", 1e6, "Delay of a channel against the one before; read from the device when live"
    ),
    "daq.start": Words(
        "Sampling starts",
        tip="At once: a run begins with the motion. At an edge: the edge is t = 0",
        choices={"now": "At once", "digital": "Digital edge", "analog": "Analogue edge"},
    ),
    "daq.start_source": Words("Edge of", tip="Digital: a terminal, PFI0. Analogue: APFI0, or a channel, I1 or ai0"),
    "daq.start_edge": Words("Edge", choices={"rising": "Rising", "falling": "Falling"}),
    "daq.start_level_v": Words("Level", "V"),
    "daq.start_pretrigger": Words(
        "Samples from before the edge",
        tip="A reference trigger: the device keeps what came before the edge. Not every device can",
    ),
    "recording.restart_after_error": Words(
        "Start again after an error",
        tip="A device that failed is started again within the run; what was lost meanwhile is a gap",
    ),
    "recording.restart_within_s": Words("Tried for", "s"),
    "daq.rate_hz": Words("Rate per channel", "Hz"),
    "recording.pretrigger_s": Words("Before the motion", "s", tip="History kept from before the trigger"),
    "recording.quiet_s": Words("Rest that ends it", "s", tip="The run ends after this long without motion"),
    "recording.maximum_s": Words("Longest run", "s"),
    "recording.threshold": Words("Trigger", "× noise", tip="Motion counts from this many times the noise on"),
    "processing.correction": Words("IQ correction", choices=CORRECTIONS),
    "processing.geometry": Words("Geometry", choices=GEOMETRIES),
    "simulation.scene": Words("Scene", choices=_SCENES),
    "simulation.drop_height_m": Words(
        "Drop height", "mm", 1e3, "From the release to the floor; empty: what the release position and the floor give"
    ),
    "simulation.restitution": Words("Restitution e", tip="Coefficient of restitution of each impact"),
    "simulation.lateral_speed_m_s": Words("Lateral speed", "m/s", tip="Horizontal speed of the sphere at its release"),
    "simulation.snr_db": Words("SNR", "dB", tip="Signal-to-noise ratio of the white noise"),
    "simulation.mismatch": Words(
        "Mismatch",
        "% of amplitude",
        100.0,
        "Size of every kind of IQ mismatch that the setup file does not set by itself",
    ),
    "simulation.seed": Words("Seed", tip="Same seed, same noise"),
}
_ANTENNAS = {
    "radar": "Wave",
    "transmitter": "Transmitter",
    "receiver": "Receiver",
    "tracer": "Tracer",
    "floor": "Floor",
    "site": "Site",
}
"""Tables whose fields stand in the antenna panel; those of the others stand in the hardware panel."""


def words_of(key: str) -> Words:
    """Return what the value of a key is called; one that has no field is called by its key.

    Parameters
    ----------
    key
        As in error messages, counted from 1: `receiver[2].tilt_deg`, `tracer.release_position_m[3]`.
    """
    words = _WORDS.get(re.sub(r"\[\d+\]", "", key))
    if words is None:
        return Words(key)
    if words.name.endswith(" x, y, z") and key.endswith("]"):
        return replace(words, name=f"{words.name.removesuffix(' x, y, z')} {'xyz'[int(key[-2]) - 1]}")
    return words


def called(key: str) -> str:
    """Return whose value it is and what it is called: `Receiver 2: Tilt`."""
    table, _, _ = key.partition(".")
    name, _, number = table.rstrip("]").partition("[")
    whose = f"{_ANTENNAS.get(name, '')} {number}".strip()
    return f"{whose}: {words_of(key).name}" if whose else words_of(key).name


def panel_of(key: str) -> str:
    """Return the title of the panel in which the field of a key stands."""
    return "Antenna calibration" if re.split(r"[.\[]", key)[0] in _ANTENNAS else "Hardware setup"


def in_words(text: str) -> str:
    """Return a sentence about the setup file with the names that the fields have."""
    return _KEY.sub(lambda found: f"“{words_of(found[0]).name}”", text).replace("[[receiver]]", "receivers")


def faults_of(error: ValidationError) -> tuple[dict[str, str], str]:
    """Return what is wrong with each value, in the words and the unit of its field, and the worst of it in one line."""
    faults: dict[str, str] = {}
    for fault in faults_in_order(error):
        key, place, text = dotted(fault["loc"]), find_place(Setup, fault["loc"]), ""
        if fault["type"] == "value_error":
            # what concerns several values, or a whole table, is said at the one it begins with
            of_table = bool(key) and place is not None and place.is_table
            sentence = f"{key}.{fault['ctx']['error']}" if of_table else str(fault["ctx"]["error"])
            text, named = in_words(sentence), _KEY.search(sentence)
            key = named[0] if named and (of_table or not key) else key
        words = words_of(key)
        if not text:
            unit = f" {words.unit}" if words.unit else ""
            shown = words.shown(fault["input"]) if fault["type"] != "missing" else ""
            allowed = place.allowed(words.scale) if place is not None else fault["msg"]
            text = f"{shown} is not allowed: {allowed}{unit}" if shown else f"a value is needed: {allowed}{unit}"
        faults.setdefault(key, text)
    key, text = next(iter(faults.items()))
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    has_field = _WORDS.get(re.sub(r"\[\d+\]", "", key)) is not None
    return faults, f"{panel_of(key)}, {called(key)}: {text}{more}" if has_field else describe(error, Setup)
