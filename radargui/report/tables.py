"""Write the tables of one run for other programs: track, motion, bounces, result.json."""

import csv
import io
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import to_jsonable_python

from radargui import __version__
from radargui.files.access import write_whole
from radargui.files.fixed_point import Column, lines
from radargui.model.arrays import BoolArray
from radargui.model.recording import channel_skew
from radargui.model.result import FreeFall, RunResult
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupValue
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.restitution.site_gravity import SiteCheck, site_check

_PIECE = 1 << 18
"""Rows made at once: 2 MB a column as float64."""
LENGTH_DECIMALS = 9
"""Metres are written to the nanometre."""
_POSITION = ("x_m", "y_m", "z_m")
_U_POSITION = ("ux_m", "uy_m", "uz_m")
_U_COMBINED = ("ux_combined_m", "uy_combined_m", "uz_combined_m")
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
BOUNCE_HEADER = (
    *("time_s", "speed_before_m_s", "speed_after_m_s", "e", "u_e", "method", "valid", "u_e_combined"),
    *("x_m", "y_m", "z_m", "u_position_m", "u_speed_before_m_s", "u_speed_after_m_s", "angle_deg", "u_angle_deg"),
    *("vt_before_m_s", "vt_after_m_s", "e_t", "u_e_t"),
)
_MOTION = ("position_m", "velocity_m_s", "acceleration_m_s2")
MOTION_HEADER = (
    "time_s",
    *("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "ax_m_s2", "ay_m_s2", "az_m_s2"),
    *("u_x_m", "u_y_m", "u_z_m", "u_vx_m_s", "u_vy_m_s", "u_vz_m_s", "u_ax_m_s2", "u_ay_m_s2", "u_az_m_s2"),
    "flight",
)


def write_tables(result: RunResult, folder: Path) -> None:
    """Write track.csv, motion.csv, bounces.csv and result.json of one run; result.json comes last.

    With fewer than three receivers there is no motion.csv.

    Parameters
    ----------
    result
        Of any status; `no_motion` gives tables with headers only.
    folder
        Made where it is missing; files of these names in it are replaced, each in one step.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    write_whole(folder / "track.csv", _track(result))
    has_track = result.status != "no_motion" and result.recording.n_receivers >= MIN_RECEIVERS
    impacts = map(asdict, result.bounces.impacts if has_track else ())
    write_whole(folder / "bounces.csv", [csv_bytes(BOUNCE_HEADER, impacts)])
    if result.recording.n_receivers >= MIN_RECEIVERS:
        write_whole(folder / "motion.csv", _motion(result))
    write_whole(folder / "result.json", [json_bytes(result_document(result))])


def track_header(n_receivers: int) -> tuple[str, ...]:
    """Return the columns of track.csv; position needs three receivers."""
    lengths = _length_names(n_receivers)
    position, combined = ((*_POSITION, *_U_POSITION), _U_COMBINED) if n_receivers >= MIN_RECEIVERS else ((), ())
    return ("time_s", *lengths, *position, "valid", "piece", *(f"u_{name}" for name in lengths), *combined)


def _length_names(n_receivers: int) -> tuple[str, ...]:
    return tuple(f"L{number}_m" for number in range(1, n_receivers + 1))


def result_document(result: RunResult) -> dict[str, object]:
    """Return what result.json says; None where the run cannot support it."""
    quality, track = result.quality, result.track
    skew = channel_skew(result.recording.digitisation, result.setup.daq)
    return {
        "status": result.status,
        "reason": result.reason or None,
        "version": __version__,
        "setup": result.setup,
        "correction_used": quality and quality.method,
        "geometry_used": track and track.geometry,
        "channel_skew_s": skew.delay_s,
        "channel_skew_from": skew.known_from,
        "channels": quality and [channel.document() for channel in quality.channels],
        "air": air_document(result.setup),
        "free_fall": result.bounces.free_fall and free_fall_document(result.bounces.free_fall, site_check(result)),
        "e_by_times": [
            {"time_s": one.time_s, "e": one.e_times, "u_e": one.u_e_times}
            for one in result.bounces.impacts
            if math.isfinite(one.e_times)
        ],
        "uncertainty_budget": result.uncertainty_budget,
        "setup_posterior": setup_posterior_document(result.setup_posterior),
        "warnings": result.warnings,
        "findings": [{**one.document(), "text": one.text} for one in result.findings],
    }


def air_document(setup: Setup) -> dict[str, object] | None:
    """Return what follows from the air that a setup tells; None where it tells none."""
    air = setup.air
    index = {"refractive_index": air.refractive_index, "u_refractive_index": air.u_refractive_index}
    return {**index, **air.gas._asdict()} if air.is_known else None


def setup_posterior_document(values: tuple[SetupValue, ...]) -> dict[str, dict[str, object]]:
    """Return what is written of the setup's values by their keys: stated, found, their u, and the pull."""
    return {one.key: {name: value for name, value in asdict(one).items() if name != "key"} for one in values}


def free_fall_document(fall: FreeFall, check: SiteCheck | None) -> dict[str, object]:
    """Return what is written of the first fall: the acceleration as measured, and its check against the site's g."""
    return {**asdict(fall), "site": check}


def _track(result: RunResult) -> Iterator[bytes | bytearray]:
    header = track_header(result.recording.n_receivers)
    yield (",".join(header) + "\n").encode()
    if result.status == "no_motion" or result.recording.n_samples == 0:
        return
    columns = columns_of(result)
    excerpt = result.recording.excerpt
    if excerpt is not None:
        lost = excerpt.first_index - excerpt.first_stored
        yield from _unknown(result, 0, lost, excerpt.first_stored, piece=int(columns["piece"].values[0]))
    yield from lines([columns[name] for name in header])
    if excerpt is not None:
        lost = int(result.recording.index()[-1]) + 1 - excerpt.last_stored
        last_piece = int(columns["piece"].values[-1])
        yield from _unknown(result, excerpt.last_stored, lost, excerpt.of_samples, piece=last_piece)


def _motion(result: RunResult) -> Iterator[bytes | bytearray]:
    yield (",".join(MOTION_HEADER) + "\n").encode()
    motion = result.motion
    if motion is None or motion.time_s.size == 0:
        return
    rows = [row for name in _MOTION for row in getattr(motion, name)]
    u_rows = [row for name in _MOTION for row in getattr(motion, f"u_{name}")]
    columns = [Column(motion.time_s, 3), *(Column(row, LENGTH_DECIMALS) for row in rows)]
    columns += [Column(row, LENGTH_DECIMALS, upwards=True) for row in u_rows]
    yield from lines([*columns, Column(motion.flight, 0)])


def columns_of(result: RunResult) -> dict[str, Column]:
    """Return the columns of the samples processed by name, those of a position too; u is NaN where the change is."""
    recording, paths, track = result.recording, result.paths, result.track
    lengths = _length_names(recording.n_receivers)
    change_m = u_m = np.broadcast_to(np.nan, (recording.n_receivers, recording.n_samples))
    position_m = u_position_m = u_combined_m = np.broadcast_to(np.nan, (3, recording.n_samples))
    piece = np.zeros(recording.n_samples, dtype=np.intp)
    if paths is not None:
        change_m, u_m = paths.change_m, np.where(np.isfinite(paths.change_m), paths.u_m, np.nan)
        piece = piece if paths.piece is None else paths.piece
    if track is not None:
        position_m, u_position_m = track.position_m, track.u_position_m
        u_combined_m = u_combined_m if track.u_combined_m is None else track.u_combined_m
    columns = {
        "time_s": Column(recording.time_s(), _time_decimals(result)),
        "valid": Column(_valid(result), 0),
        "piece": Column(piece, 0),
    }
    for names, rows, upwards in (
        (lengths, change_m, False),
        (_POSITION, position_m, False),
        (_U_POSITION, u_position_m, True),
        (_U_COMBINED, u_combined_m, True),
        ([f"u_{name}" for name in lengths], u_m, True),
    ):
        columns |= {name: Column(row, LENGTH_DECIMALS, upwards=upwards) for name, row in zip(names, rows, strict=True)}
    return columns


def _unknown(result: RunResult, first: int, lost: int, last: int, *, piece: int) -> Iterator[bytes | bytearray]:
    """Give the rows of stored samples first:last that were not processed; `lost` samples went missing before."""
    rate, header = result.recording.digitisation.sample_rate_hz, track_header(result.recording.n_receivers)
    for begin in range(first, last, _PIECE):
        count = min(_PIECE, last - begin)
        nothing = Column(np.full(count, np.nan), LENGTH_DECIMALS)
        known = {
            "time_s": Column((np.arange(begin, begin + count) + lost) / rate, _time_decimals(result)),
            "valid": Column(np.zeros(count, dtype=np.bool_), 0),
            "piece": Column(np.full(count, piece, dtype=np.intp), 0),
        }
        yield from lines([known.get(name, nothing) for name in header])


def _time_decimals(result: RunResult) -> int:
    """Return how many decimals say index / rate exactly, at most 12 (a picosecond)."""
    if result.recording.file_time_s is None:
        rate = result.recording.digitisation.sample_rate_hz
        for decimals in (3, 6, 9):
            steps = 10.0**decimals / rate
            if steps >= 1.0 and steps == round(steps):
                return decimals
    return 12


def _valid(result: RunResult) -> BoolArray:
    if result.status != "rejected":
        if result.track is not None:
            return result.track.valid
        if result.paths is not None and result.recording.n_receivers < MIN_RECEIVERS:
            return np.asarray(result.paths.valid.all(axis=0))
    return np.zeros(result.recording.n_samples, dtype=np.bool_)


def csv_bytes(header: Sequence[str], rows: Iterable[Mapping[str, object]]) -> bytes:
    """Return a CSV file of rows, each with its values by the name of their column; what is not there is nan."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(row.get(name)) for name in header] for row in rows)
    return text.getvalue().encode(errors="replace")


def _cell(value: object) -> str:
    """Return what stands in a cell: numbers with 12 significant digits, nan where unknown, booleans as 0 or 1."""
    if isinstance(value, str):
        return safe_cell(value)
    if isinstance(value, int):
        return str(int(value))
    return f"{value:.12g}" if isinstance(value, float) and math.isfinite(value) else "nan"


def safe_cell(text: str) -> str:
    """Return a text that no spreadsheet takes for a formula: an apostrophe is put before one."""
    return "'" + text if text.lstrip(" ").startswith(_FORMULA) else text


LARGEST_BYTES = 10_000_000
"""Of a result.json (chosen by hand): a larger one counts as not current, and is not read into memory."""


def tables_are_current(folder: Path, setup: Setup) -> bool:
    """Return whether the tables in a folder were made by this version with this setup; result.json comes last."""
    path = folder / "result.json"
    try:
        if path.stat().st_size > LARGEST_BYTES:
            return False
        document = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    wanted = json.loads(json_bytes({"setup": setup, "version": __version__}))
    return isinstance(document, dict) and all(document.get(key) == value for key, value in wanted.items())


def plain_value(value: object) -> Any:
    """Return dicts, lists, texts, numbers, booleans and None; NaN and infinities become None.

    Takes mappings, sequences, arrays, dataclasses and models, nested in any way; anything else becomes its text.
    """
    return to_jsonable_python(value, by_alias=True, inf_nan_mode="null", fallback=_as_plain)


def _as_plain(value: object) -> object:
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else str(value)


def json_bytes(value: object) -> bytes:
    """Return a value as indented JSON in UTF-8 that every reader takes: no NaN, no Infinity."""
    return (json.dumps(plain_value(value), ensure_ascii=False, allow_nan=False, indent=2) + "\n").encode(
        errors="replace"
    )
