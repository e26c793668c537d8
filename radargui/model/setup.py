"""The setup file: read with every fault named, written so that comments stay, changed by key.

The settings of processing: the correction and the geometry.
"""

from __future__ import annotations

import math
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import tomlkit
from pydantic import AfterValidator, ConfigDict, Field, ValidationError, model_validator
from tomlkit.exceptions import TOMLKitError

from radargui.model.calibration import CalibrationContent, CalibrationReference, content_of, read_calibration
from radargui.model.daq import Daq, RecordingLimits
from radargui.model.errors import FileError, ProcessingError, SetupError, worded
from radargui.model.gravity import Air
from radargui.model.plugins import plugins
from radargui.model.radar import MAX_RECEIVERS, Container, Floor, Radar, Receiver, Site, Tracer, Transmitter
from radargui.model.recording import Recording, iq_names
from radargui.model.scattering import MIN_SHARE, ReceivedField, received_fields
from radargui.model.section import ExactWhole, Flag, Section, Whole
from radargui.model.setup_error import describe
from radargui.model.simulation import Simulation

CORRECTIONS = ("joint", "flights", "adaptive", "published", "ellipse", "none")


def _known_correction(name: str) -> str:
    if name not in CORRECTIONS and name not in (added := plugins("corrections")):
        raise ValueError(f"allowed: {', '.join((*CORRECTIONS, *added))}")
    return name


Correction = Annotated[str, AfterValidator(_known_correction), Field(json_schema_extra={"enum": list(CORRECTIONS)})]
Geometry = Literal["exact", "plane"]


class Processing(Section):
    """How samples become a track.

    Attributes
    ----------
    correction
        See method.md; also the name of a plug-in.
    geometry
        plane: the antennas taken as infinitely far away.
    pool_setup
        Whether the joint correction uses what the other runs of a session say of antennas, release and wavelength.
    drop
        Which of several drops in one record, each from a rest, joint and flights measure: 1 is the first.
    """

    correction: Correction = "joint"
    geometry: Geometry = "exact"
    pool_setup: Flag = True
    drop: Annotated[Whole, Field(ge=1)] = 1


MEASURING = ("radar", "transmitter", "receiver", "tracer", "floor", "container", "air")
"""Tables that position, e and g are computed with; the others are about acquisition and processing."""


class Setup(Section):
    """Geometry of the antennas, tracer, floor, acquisition, simulation and processing."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)

    schema_version: Annotated[Literal[1], ExactWhole, Field(alias="schema", description="1 in this version")]
    radar: Radar
    transmitter: Transmitter
    receiver: Annotated[tuple[Receiver, ...], Field(min_length=1, max_length=MAX_RECEIVERS)]
    tracer: Tracer = Tracer()
    floor: Floor = Floor()
    container: Container = Container()
    air: Air = Air()
    site: Site = Site()
    calibration: CalibrationReference = CalibrationReference()
    daq: Daq = Daq()
    recording: RecordingLimits = RecordingLimits()
    simulation: Simulation = Simulation()
    processing: Processing = Processing()

    @model_validator(mode="after")
    def _acquisition_fits(self) -> Setup:
        daq, channels = self.daq, self.daq.channels
        if channels is not None and len(channels) != 2 * len(self.receiver):
            wanted = ", ".join(iq_names(len(self.receiver)))
            raise ValueError(
                f"daq.channels names {len(channels)} channels: allowed {2 * len(self.receiver)} "
                f"for {len(self.receiver)} [[receiver]] ({wanted})"
            )
        if channels is not None and len(set(channels)) != len(channels):
            raise ValueError(f"daq.channels = {list(channels)}: allowed are different channels, one is named twice")
        if daq.start != "now" and daq.start_source is None:
            example = "PFI0" if daq.start == "digital" else "APFI0 or I1"
            raise ValueError(f'daq.start = "{daq.start}", allowed: with daq.start_source, for example {example}')
        if daq.start == "now" and daq.start_pretrigger:
            raise ValueError('daq.start_pretrigger = true, allowed: with daq.start = "digital" or "analog"')
        if daq.remote_certificate is not None and daq.remote is None:
            raise ValueError("daq.remote_certificate is given, allowed: together with daq.remote")
        return self

    @model_validator(mode="after")
    def _wave_is_in_the_air(self) -> Setup:
        if not self.air.is_known:
            return self
        if self.radar.refractive_index is not None:
            given = f"radar.refractive_index = {self.radar.refractive_index:g}"
            raise ValueError(f"{given}, allowed: left out beside [air], which gives it")
        # frozen for all others: here it is being made
        object.__setattr__(self, "radar", self.radar.in_air(self.air.refractive_index))
        return self

    @model_validator(mode="after")
    def _every_receiver_gets_a_signal(self) -> Setup:
        turned = [n for n, one in enumerate(self.receiver, 1) if one.polarization_deg is not None]
        # only the angle between both fields says what a receiver gets
        if turned and self.transmitter.polarization_deg is None:
            raise ValueError(
                f"receiver[{turned[0]}].polarization_deg = {self.receiver[turned[0] - 1].polarization_deg:g}, allowed: "
                "together with transmitter.polarization_deg"
            )
        for n, field in enumerate(self.received_fields() if turned else (), 1):
            # nearly crossed: a degree of error in an angle changes such a signal by a third
            if field.share < MIN_SHARE:
                raise ValueError(
                    f"receiver[{n}].polarization_deg = {field.angle_deg:g} gets {100.0 * field.share:.1f} % of the "
                    f"strongest signal from the centre, allowed: {100.0 * MIN_SHARE:g} % and more; "
                    f"{field.strongest_deg:.1f} gives the strongest"
                )
        return self

    def received_fields(self) -> tuple[ReceivedField, ...]:
        """Return what each receiver gets from a metal sphere in the centre; no polarisation given counts as 0."""
        polarization_deg = self.transmitter.polarization_deg or 0.0
        return received_fields(self.radar, self.transmitter, self.receiver, self.tracer, polarization_deg)

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return len(self.receiver)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Canonical names of the voltages: I1, Q1, ..."""
        return iq_names(self.n_receivers)

    @property
    def physical_channels(self) -> tuple[str, ...]:
        """Device channels in the order of `channel_names`."""
        if self.daq.channels is not None:
            return self.daq.channels
        return tuple(f"ai{number}" for number in range(2 * self.n_receivers))

    def demand_pairs(self, recording: Recording) -> None:
        """Refuse a recording that has not an IQ pair for each receiver, or no samples.

        Raises
        ------
        ProcessingError
            It has more channels or fewer, or holds no samples.
        """
        # a pair too many or too few would give every receiver another one's geometry
        if recording.n_receivers != self.n_receivers or len(recording.digitisation.channel_names) % 2:
            names = ", ".join(recording.digitisation.channel_names)
            n, n_channels = self.n_receivers, recording.digitisation.n_channels
            facts = {"n_channels": n_channels, "names": names, "receivers": n, "needed": 2 * n}
            raise worded(ProcessingError, "pairs_to_process", name=recording.name, **facts)
        if recording.n_samples == 0:
            raise ProcessingError(f"{recording.name} holds no samples", reasons=["the recording ended before it began"])


MAX_KEY_PARTS = 32
"""Joined by points; keys of a setup have two or three. Chosen by hand: the parser's memory grows with their square."""
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_ENDLESS_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MAX_KEY_PARTS}}}")


def load_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        Not TOML, or nested or long beyond all use; the text says where.
    """
    # The parser's memory grows with the square of the number of parts of a key.
    if _ENDLESS_KEY.search(text):
        raise ValueError("a key of too many parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError("tables or lists nested too deep") from None
    except ValueError:
        raise ValueError("a number has too many digits") from None


MAXIMUM_BYTES = 1_000_000
"""More is no setup and is not read into memory; setups have some kB. Chosen by hand."""


def parse_setup(text: str, name: str = "setup") -> Setup:
    """Return the setup that a TOML text describes.

    Raises
    ------
    SetupError
        Not TOML, or a key missing, unknown or out of range; one line names key, value and allowed range.
    """
    try:
        document = load_toml(text)
    except ValueError as error:
        text = " ".join(str(error).split())
        remedy = "Correct that place or start from a shipped setup."
        raise SetupError(f"{name} is not TOML: {text}.", remedy=remedy) from None
    return validate_setup(document, name)


def validate_setup(document: dict[str, Any], name: str = "setup") -> Setup:
    """Return the setup that plain tables describe.

    Raises
    ------
    SetupError
        A key missing, unknown or out of range; one line names key, value and allowed range.
    """
    try:
        return Setup.model_validate(document)
    except ValidationError as error:
        raise SetupError(f"{name}: {describe(error, Setup)}") from None


def read_setup(path: str | Path) -> Setup:
    """Return the setup in a file.

    Raises
    ------
    SetupError
        Unreadable, not TOML, or invalid.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise SetupError(f"{path} is larger than a setup file can be", remedy="Give the TOML file of a setup.")
        # editors of Windows put a mark before the text
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise SetupError(f"{path}: {error.strerror or error}", remedy="Check the path of the setup file.") from None
    except UnicodeDecodeError:
        raise SetupError(f"{path} is not TOML: not UTF-8 text", remedy="Give the TOML file of a setup.") from None
    return _with_calibration(parse_setup(text, str(path)), path)


def _with_calibration(setup: Setup, path: Path) -> Setup:
    """Return the setup with what its calibration file says, unless it carries that along; its file's whole path."""
    own = setup.calibration
    if own.file is None:
        return setup
    file = path.absolute().parent / own.file
    content = own.content
    if content is None:
        try:
            content = content_of(read_calibration(file))
        except FileError as error:
            raise SetupError(f"{path}: calibration.file: {error}", remedy="Correct or remove that key.") from None
    return with_calibration(setup, content, file)


def with_calibration(setup: Setup, content: CalibrationContent, file: Path) -> Setup:
    """Return the setup that refers to a calibration and carries it along; its antennas stay as they are."""
    own = setup.calibration.model_copy(update={"file": str(file.absolute()), "content": content})
    # what is set counts as given, also where it is the default
    return setup.model_copy(update={"calibration": own})


def _for_file(setup: Setup, path: Path) -> Setup:
    """Return the setup as its file shall say it: it refers to a calibration that can be read again, else carries it."""
    own, folder = setup.calibration, path.absolute().parent
    if own.file is None:
        return setup
    file = Path(own.file)
    if file.is_relative_to(folder):
        own = own.model_copy(update={"file": file.relative_to(folder).as_posix()})
    try:
        if content_of(read_calibration(folder / file)) == own.content:
            own = own.model_copy(update={"content": None})
    except FileError:
        # it was moved or deleted since
        pass
    return setup.model_copy(update={"calibration": own})


def dump_setup(setup: Setup, original: str = "") -> str:
    """Return the setup as TOML; where `original` is given its comments and order stay."""
    document = tomlkit.parse(original) if original else tomlkit.document()
    _update(document, plain(setup))
    return tomlkit.dumps(document)


def plain(setup: Setup) -> dict[str, Any]:
    """Return the setup as plain tables: what was set or differs from the default, nothing that is None."""
    whole = setup.model_dump(by_alias=True, exclude_none=True, mode="json")
    given = setup.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True, mode="json")
    explicit = setup.model_dump(by_alias=True, exclude_none=True, exclude_unset=True, mode="json")
    # what was written is known, also where it is the default: that is more than a default says
    return {
        key: whole[key] if key in ("schema", "receiver") else {**explicit.get(key, {}), **given.get(key, {})}
        for key in whole
        if key in given or key in explicit
    }


def _update(target: Any, source: dict[str, Any]) -> None:
    for key in [key for key in target if key not in source]:
        del target[key]
    for key, value in source.items():
        old = target.get(key)
        if isinstance(value, dict) and hasattr(old, "keys"):
            _update(old, value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            _update_tables(target, key, value)
        # left alone where equal: comments and the way a number is written stay
        elif old is None or old != value:
            target[key] = value


def _update_tables(target: Any, key: str, rows: list[dict[str, Any]]) -> None:
    if not isinstance(target.get(key), tomlkit.items.AoT):
        target[key] = tomlkit.aot()
    tables = target[key]
    del tables[len(rows) :]
    for table, row in zip(tables, rows, strict=False):
        _update(table, row)
    for row in rows[len(tables) :]:
        tables.append(row)


def write_setup(setup: Setup, path: Path, like: Path | None = None) -> None:
    """Write the setup; comments of a file that is there survive, else those of `like`; replaced in one step.

    Raises
    ------
    SetupError
        The folder cannot be written.
    """
    setup = _for_file(setup, path)
    try:
        old = path if path.exists() else like
        original = "" if old is None else old.read_text(encoding="utf-8-sig")
        text = dump_setup(setup, original)
    except (OSError, UnicodeDecodeError, TOMLKitError):
        text = dump_setup(setup)
    partial = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            # a crash between the two steps must leave one of the files whole
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        raise SetupError(
            f"{path}: cannot be written: {error.strerror or error}", remedy="Choose another folder."
        ) from None


def changed(setup: Setup, changes: Mapping[str, Any], name: str = "setup") -> Setup:
    """Return the setup with some keys changed and all of it checked again.

    Parameters
    ----------
    setup
        Where the other keys come from.
    changes
        From "table.key" to the new value; None leaves the key as it is.
    name
        Whose wish it is, for messages.

    Raises
    ------
    SetupError
        A new value is not allowed.
    """
    wanted = {key: value for key, value in changes.items() if value is not None}
    if not wanted:
        return setup
    document = plain(setup)
    for place, value in wanted.items():
        table, _, key = place.partition(".")
        document.setdefault(table, {})[key] = value
    return validate_setup(document, name)


def moved(setup: Setup, key: str, by: float) -> Setup:
    """Return the setup with one value moved, unchecked: for what results change by when it is a little wrong.

    Parameters
    ----------
    setup
        Where the value comes from; a refractive index or a receiver's polarisation that is not given counts as what
        is taken for it. A transmitter with `position_m` moves along its direction.
    key
        As in `model.assumed`: receiver[2].tilt_deg, tracer.release_position_m[3].
    by
        In the value's unit.
    """
    table_name, index, name, axis = _parts(key)
    whole = getattr(setup, table_name)
    table = whole if index is None else whole[index]
    value = getattr(table, name)
    if name == "distance_m" and value is None:
        # what a tape measures wrongly is the distance, not the direction
        stretched = 1.0 + by / math.hypot(*table.position_m)
        name, value = "position_m", tuple(stretched * x for x in table.position_m)
    elif axis is not None and value is None:
        # beside the axis on which it was stated to stand
        value = tuple(x + by * (n == axis) for n, x in enumerate(table.place_m))
        table = table.model_copy(update={"distance_m": None})
    elif axis is not None:
        value = (*value[:axis], value[axis] + by, *value[axis + 1 :])
    else:
        if value is None:
            # of what is not given the value that is taken for it moves
            value = table.index if index is None else setup.received_fields()[index].angle_deg
        value += by
    table = table.model_copy(update={name: value})
    update = table if index is None else (*whole[:index], table, *whole[index + 1 :])
    return setup.model_copy(update={table_name: update})


def value_of(setup: Setup, key: str) -> float:
    """Return one value of a setup, a key as for `moved`; of what is not given what is taken for it."""
    table_name, index, name, axis = _parts(key)
    whole = getattr(setup, table_name)
    table = whole if index is None else whole[index]
    value = getattr(table, name)
    if name in ("distance_m", "position_m") and value is None:
        value = math.hypot(*table.place_m) if name == "distance_m" else table.place_m
    if value is None:
        value = table.index if index is None else setup.received_fields()[index].angle_deg
    return float(value if axis is None else value[axis])


def _parts(key: str) -> tuple[str, int | None, str, int | None]:
    """Split receiver[2].position_m[1] into table, number, name and axis, counted from 0."""
    place, name = key.split(".")
    return *_indexed(place), *_indexed(name)


def _indexed(part: str) -> tuple[str, int | None]:
    """Split receiver[2] into its name and 1."""
    found = re.fullmatch(r"(\w+)\[(\d+)\]", part)
    return (found[1], int(found[2]) - 1) if found else (part, None)
