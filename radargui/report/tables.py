"""The tables of one run: track.csv, bounces.csv and result.json, as other programs rely on them."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from radargui import __version__
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.result import RunResult
from radargui.report.fixed_point import Column, lines
from radargui.report.plain_values import json_bytes
from radargui.report.whole_file import write_whole

_PIECE = 1 << 18
LENGTH_DECIMALS = 9
"""Metres are written to the nanometre."""
BOUNCE_HEADER = ("time_s", "speed_before_m_s", "speed_after_m_s", "e", "u_e", "method", "valid")


def write_tables(result: RunResult, folder: Path) -> None:
    """Write track.csv, bounces.csv and result.json of one run; result.json comes last.

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
    write_whole(folder / "bounces.csv", [_bounces(result)])
    write_whole(folder / "result.json", [json_bytes(result_document(result))])


def track_header(n_receivers: int) -> tuple[str, ...]:
    """Return the columns of track.csv; position needs three receivers."""
    position = ("x_m", "y_m", "z_m", "ux_m", "uy_m", "uz_m") if n_receivers >= 3 else ()
    return ("time_s", *(f"L{number}_m" for number in range(1, n_receivers + 1)), *position, "valid")


def result_document(result: RunResult) -> dict[str, object]:
    """Return what result.json says; None where the run cannot support it."""
    corrected, track = result.corrected, result.track
    return {
        "status": result.status,
        "reason": result.reason or None,
        "version": __version__,
        "setup": result.setup,
        "correction_used": corrected.method if corrected is not None else None,
        "geometry_used": track.geometry if track is not None else None,
        "channels": corrected.channels if corrected is not None else None,
        "free_fall": result.bounces.free_fall,
        "calibration_uncertainty": result.calibration_uncertainty,
        "warnings": result.warnings,
    }


def _track(result: RunResult) -> Iterator[bytes]:
    n_receivers = result.recording.n_receivers
    yield (",".join(track_header(n_receivers)) + "\n").encode()
    if result.status == "no_motion" or result.recording.n_samples == 0:
        return
    excerpt = result.recording.excerpt
    if excerpt is not None:
        yield from _unknown(result, 0, excerpt.first_index - excerpt.first_stored, excerpt.first_stored)
    time_s = result.recording.time_s()
    columns = [Column(time_s, _time_decimals(result))]
    columns += [Column(row, LENGTH_DECIMALS) for row in _changes(result)]
    if n_receivers >= 3:
        position, uncertainty = _positions(result)
        columns += [Column(row, LENGTH_DECIMALS) for row in position]
        columns += [Column(row, LENGTH_DECIMALS, upwards=True) for row in uncertainty]
    columns.append(Column(_valid(result), 0))
    yield from lines(columns)
    if excerpt is not None:
        lost = int(result.recording.index()[-1]) + 1 - excerpt.last_stored
        yield from _unknown(result, excerpt.last_stored, lost, excerpt.of_samples)


def _unknown(result: RunResult, first: int, lost: int, last: int) -> Iterator[bytes]:
    """Give the rows of stored samples first:last that were not processed; `lost` samples went missing before."""
    rate, width = result.recording.digitisation.sample_rate_hz, len(track_header(result.recording.n_receivers)) - 2
    for begin in range(first, last, _PIECE):
        count = min(_PIECE, last - begin)
        nothing = Column(np.full(count, np.nan), LENGTH_DECIMALS)
        time = Column((np.arange(begin, begin + count) + lost) / rate, _time_decimals(result))
        yield from lines([time, *(nothing for _ in range(width)), Column(np.zeros(count, dtype=np.bool_), 0)])


def _time_decimals(result: RunResult) -> int:
    """Return how many decimals say index / rate exactly, at most 12 (a picosecond)."""
    if result.recording.file_time_s is None:
        rate = result.recording.digitisation.sample_rate_hz
        for decimals in (3, 6, 9):
            steps = 10.0**decimals / rate
            if steps >= 1.0 and steps == round(steps):
                return decimals
    return 12


def _changes(result: RunResult) -> FloatArray:
    if result.paths is None:
        return np.full((result.recording.n_receivers, result.recording.n_samples), np.nan)
    return result.paths.change_m


def _positions(result: RunResult) -> tuple[FloatArray, FloatArray]:
    if result.track is None:
        unknown = np.full((3, result.recording.n_samples), np.nan)
        return unknown, unknown
    return result.track.position_m, result.track.u_position_m


def _valid(result: RunResult) -> BoolArray:
    if result.track is not None:
        return result.track.valid
    if result.paths is not None and result.recording.n_receivers < 3:
        return np.asarray(result.paths.valid.all(axis=0))
    return np.zeros(result.recording.n_samples, dtype=np.bool_)


def _bounces(result: RunResult) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(BOUNCE_HEADER)
    if result.status != "no_motion" and result.recording.n_receivers >= 3:
        for impact in result.bounces.impacts:
            figures = (impact.time_s, impact.speed_before_m_s, impact.speed_after_m_s, impact.e, impact.u_e)
            writer.writerow([*map(number, figures), impact.method, int(impact.valid)])
    return text.getvalue().encode()


def number(value: float) -> str:
    """Return a number for a CSV cell with 12 significant digits, nan where unknown."""
    return f"{value:.12g}" if math.isfinite(value) else "nan"
