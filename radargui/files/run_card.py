"""Read what lists and searches show of a run: summary, thumbnail, health, origin."""

import json
import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from radargui import __version__
from radargui.files import hdf5, run_layout as layout
from radargui.files.run_file import markers_in
from radargui.model.arrays import FloatArray, lowest_and_highest
from radargui.model.drop import RunOrigin
from radargui.model.errors import FileError
from radargui.model.result import Bounce, FreeFall, RunResult

HEALTH = "health"
_RECORD = "record"


def put_health(file: Any, record: Mapping[str, object]) -> None:
    """Store a record in an open run file, in place of an older one; NaN and infinity are refused."""
    group = file.require_group(HEALTH)
    hdf5.put_text(group.attrs, _RECORD, json.dumps(dict(record), allow_nan=False))
    hdf5.seal(group.attrs)


def read_health(path: Path) -> dict[str, object] | None:
    """Return the health record of a run; None where it holds none, or a damaged one.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        return health_in(file)


def health_in(file: Any) -> dict[str, object] | None:
    """Return the health record in an open run file; None where it holds none, or a damaged one."""
    if HEALTH in file and hdf5.is_sound(file[HEALTH].attrs):
        with suppress(ValueError):
            record = json.loads(hdf5.text(file[HEALTH].attrs, _RECORD) or "null")
            return record if isinstance(record, dict) else None
    return None


_VERDICTS = ("rejected", "usable", "good")


def summarise(result: RunResult) -> dict[str, object]:
    """Return the figures of a run's first bounce and first fall; None where there is none or it is not valid.

    Parameters
    ----------
    result
        What the run gave.

    Returns
    -------
    dict
        `status`, `reason`, `drop_height_m`, `impact_speed_m_s`, `e`, `u_e`, `u_e_combined`, `e_times`,
        `u_e_times` (from times alone), `g_m_s2`, `u_g_m_s2`,
        `u_g_combined_m_s2` (combined: with what calibration and sphere leave open; else statistical), `correction`,
        `geometry`, `version`, `n_bounces` (all impacts), `verdict` (the worst receiver's), `preliminary` (see
        `RunResult`), `from_rest` (whether the rest before the motion was recorded), `warnings`. JSON can hold it.
    """
    bounce = next((bounce for bounce in result.bounces.impacts[:1] if bounce.valid), None)
    fall, budget = result.bounces.free_fall, result.uncertainty_budget
    corrected, track = result.corrected, result.track
    verdicts = {channel.verdict for channel in corrected.channels} if corrected else set()
    return {
        "status": result.status,
        "reason": result.reason,
        "drop_height_m": _finite(fall, "drop_height_m"),
        "impact_speed_m_s": _finite(bounce, "speed_before_m_s"),
        **{key: _finite(bounce, key) for key in ("e", "u_e", "u_e_combined", "e_times", "u_e_times")},
        **{key: _finite(fall, key) for key in ("g_m_s2", "u_g_m_s2")},
        "u_g_combined_m_s2": budget.g_m_s2.combined if fall and budget else None,
        "correction": corrected.method if corrected else result.setup.processing.correction,
        "geometry": track.geometry if track else result.setup.processing.geometry,
        "version": __version__,
        "n_bounces": len(result.bounces.impacts),
        "verdict": next((verdict for verdict in _VERDICTS if verdict in verdicts), None),
        "preliminary": result.preliminary,
        "from_rest": result.segment is not None and result.segment.has_rest,
        "warnings": list(result.warnings),
    }


def sound_results(file: Any) -> Any:
    """Return the group of results in an open run file; None where there is none, or a damaged one."""
    results = file.get(layout.RESULTS)
    return results if results is not None and hdf5.is_sound(results.attrs) else None


def summary_in(results: Any) -> dict[str, object]:
    """Return the summary stored in a group of results; empty where there is none."""
    summary, warnings = (json.loads(hdf5.text(results.attrs, one) or "null") for one in ("summary", "warnings"))
    return {**summary, "warnings": warnings or []} if summary and isinstance(summary, dict) else {}


def _finite(of: Bounce | FreeFall | None, figure: str) -> float | None:
    # JSON knows no NaN
    return float(value) if of is not None and math.isfinite(value := getattr(of, figure)) else None


BINS = 128
"""As many as the picture in a list has pixels."""
_MARGIN = 0.1
"""Share of the motion shown before and after it. Chosen by hand."""


@dataclass(frozen=True, slots=True)
class Thumbnail:
    """Height against time.

    Attributes
    ----------
    time_s, z_m
        Shape (n,), at most 2 * BINS points; NaN where unknown.
    """

    time_s: FloatArray
    z_m: FloatArray


def put_thumbnail(group: Any, result: RunResult) -> None:
    """Store the thumbnail of a result in its group: lowest and highest z of each bin around the motion."""
    track, segment = result.track, result.segment
    if track is None or not track.time_s.size:
        return
    n = track.time_s.size
    first, last = (segment.first, segment.last) if segment else (0, n)
    margin = round(_MARGIN * (last - first))
    first, last = max(first - margin, 0), min(last + margin, n)
    z, t = track.position_m[2, first:last], track.time_s[first:last]
    size = max(1, -(-z.size // BINS))
    whole = z.size // size * size
    ends = np.stack(lowest_and_highest(z[:whole], size), axis=1)
    if result.paths is not None:
        restarts = result.paths.restarts() - first
        # unknown, so that no line joins two pieces
        ends[restarts[(restarts >= 0) & (restarts < whole)] // size] = np.nan
    places = np.repeat(t[size // 2 : whole : size], 2)
    thumbnail = group.create_group(layout.THUMBNAIL)
    for name, values, unit in (("time_s", places, "s"), ("z_m", ends.ravel(), "m")):
        hdf5.put_text(thumbnail.create_dataset(name, data=values).attrs, "unit", unit)


def read_thumbnail(path: Path) -> Thumbnail | None:
    """Return the thumbnail stored with the results of a run; None where there is none.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        return thumbnail_in(file[layout.RESULTS], path) if layout.RESULTS in file else None


def thumbnail_in(group: Any, path: Path) -> Thumbnail | None:
    """Return the thumbnail in a group of results; None where there is none.

    Raises
    ------
    FileError
        It is damaged.
    """
    if layout.THUMBNAIL not in group:
        return None
    time_s, z_m = (
        np.asarray(hdf5.dataset(group[layout.THUMBNAIL], name, path, (1,))[:], dtype=np.float64)
        for name in ("time_s", "z_m")
    )
    return Thumbnail(time_s, z_m) if time_s.shape == z_m.shape else None


@dataclass(frozen=True, slots=True)
class RunCard:
    """What a run file says about itself, without its samples.

    Attributes
    ----------
    started_at
        ISO 8601; empty where unknown.
    finished
        False after a crash, a failure, or while it is being recorded.
    recovered_at
        ISO 8601 date and time at which it was finished after a crash; empty for others.
    n_samples, sample_rate_hz
        Of each channel.
    summary
        See `files.run_card.summarise`; empty where not processed.
    markers
        The operator's notes.
    origin
        Where the samples come from.
    """

    started_at: str = ""
    finished: bool = True
    recovered_at: str = ""
    n_samples: int = 0
    sample_rate_hz: float = 0.0
    summary: dict[str, object] = field(default_factory=dict)
    markers: tuple[str, ...] = ()
    origin: RunOrigin = field(default_factory=RunOrigin)


def read_run_card(path: Path) -> RunCard:
    """Return the card of a run.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        # the header's own checksum is left to those who read samples: it would double the time
        results = sound_results(file)
        return RunCard(
            started_at=hdf5.text(raw.attrs, "started_at"),
            finished=hdf5.number(file.attrs, "complete") != 0.0,
            recovered_at=hdf5.text(file.attrs, "recovered_at"),
            n_samples=int(raw.shape[1]),
            sample_rate_hz=hdf5.number(raw.attrs, "sample_rate_hz") or 0.0,
            summary={} if results is None else summary_in(results),
            markers=tuple(marker.text for marker in markers_in(file, path)),
            origin=_origin(file),
        )


def origin_attributes(source: str, file: Path | None, device: str) -> dict[str, str]:
    """Return what a run file says of its source, see `RunOrigin`.

    Parameters
    ----------
    source
        See `sources.factory.source_kinds`.
    file
        What is replayed.
    device
        Name of the device in the setup; counts where it is read.
    """
    said = {"source": source}
    if source == "replay" and file is not None:
        said["replay_of"] = str(file.resolve())
    return said | ({"source_device": device} if source == "ni" else {})


def origin_of_source(source: str, file: Path | None, device: str) -> RunOrigin:
    """Return where the samples of a source come from, before the first of them; parameters as above."""
    if source != "replay":
        return RunOrigin("simulated") if source == "simulated" else RunOrigin(source=_source_words(source, device))
    of_simulated = False
    if file is not None:
        # no file of this program, or one that cannot be read: the source says what is wrong with it
        with suppress(FileError):
            played = read_run_card(file).origin
            of_simulated = played.kind == "simulated" or played.of_simulated
    return RunOrigin("replay", of_simulated=of_simulated)


def _source_words(source: str, device: str) -> str:
    return {"ni": f"NI {device}".strip(), "import": "IMPORTED"}.get(source, source)


def _origin(file: Any) -> RunOrigin:
    attributes = file.attrs
    crcs = np.ravel(attributes.get("crc32", ())).tolist()
    samples = ":".join(map(str, [int(hdf5.number(attributes, "n_samples") or 0), *crcs])) if crcs else ""
    # 0.1 said so only of the device, an imported simulation says no more, and a replay keeps the device of its file
    simulated = hdf5.text(attributes, "device").startswith("simulated") or layout.TRUTH in file
    if hdf5.text(attributes, "source") == "replay":
        found = (health_in(file) or {}).get("first_sample")
        first = found if isinstance(found, int) else None
        return RunOrigin("replay", samples, hdf5.text(attributes, "replay_of"), first, simulated)
    if simulated:
        return RunOrigin("simulated", samples)
    source, device = (hdf5.text(attributes, key) for key in ("source", "source_device"))
    return RunOrigin("measured", samples, source=_source_words(source, device))


def read_origin(path: Path) -> str:
    """Return where an imported run comes from, file, format and program, for people; empty for a recorded one.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        name, kind, program, layout_text = (
            hdf5.text(file.attrs, f"imported_{key}") for key in ("from", "format", "program", "layout")
        )
    if not name:
        return ""
    kind = f"{kind}: {layout_text}" if layout_text else kind
    return f"{name} ({kind})" + (f", written by {program}" if program else "")
