"""Store results beside the samples of a run.

They can be computed again at any time. Rewrite a run file and put it in place of the old one in one step, to change it
or to finish it.
"""

import contextlib
import itertools
import json
import os
import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, astuple, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, get_type_hints

import h5py
import numpy as np
from numpy.typing import DTypeLike

from radargui import __version__
from radargui.files import hdf5, run_layout as layout
from radargui.files.access import why
from radargui.files.overview import OverviewMaker, write_overview
from radargui.files.run_card import health_in, put_health, put_thumbnail, sound_results, summarise, summary_in
from radargui.files.staged_file import StagedFile
from radargui.model.errors import FileError, worded
from radargui.model.result import Bounce, Bounces, FreeFall, RunResult
from radargui.model.setup import Setup, dump_setup
from radargui.model.setup_posterior import unknown_inputs

_LEFT_BEHIND_S = 86_400.0
"""Age of a half-written copy that nobody can be working on any more: no rewriting takes a day."""
_numbers = itertools.count(1)


@contextmanager
def rewritten(path: Path, said: str) -> Iterator[tuple[Any, Any]]:
    """Hand out a run file and an empty new one, which takes the place of the first when the block ends well.

    Parameters
    ----------
    path
        Run file.
    said
        What a refusal says cannot be done.

    Raises
    ------
    FileError
        The run cannot be read or the folder cannot be written; the recording is as it was.
    """
    partial: Path | None = None
    try:
        with hdf5.opened(path, "a run file", layout.is_run) as source:
            try:
                staged = _new_file(path)
                partial = staged.path
                with closing(staged):
                    with h5py.File(staged, "w") as target:
                        yield source, target
                    staged.commit()
                    staged.sync()
            except (OSError, RuntimeError, ValueError, TypeError) as error:
                raise worded(FileError, "not_rewritten", path=path, said=said, why=why(error)) from error
        try:
            partial.replace(path)
        except OSError as error:
            raise worded(FileError, "not_rewritten", path=path, said=said, why=why(error)) from error
    finally:
        if partial is not None:
            # gone where it took its place
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)


def _new_file(path: Path) -> StagedFile:
    """Make a working file under a name of its own: two programs that write results must not share one."""
    for old in path.parent.glob(f"{path.name}.*.part"):
        with contextlib.suppress(OSError):
            if time.time() - old.stat().st_mtime > _LEFT_BEHIND_S:
                # what a crash left behind is a copy
                old.unlink()
    while True:
        with contextlib.suppress(FileExistsError):
            return StagedFile(path.with_name(f"{path.name}.{os.getpid()}-{next(_numbers)}.part"), automatic=True)


ASIDE = ".unfinished"
"""Added to the name of a file that holds more than could be taken over; it is kept."""
_MADE_ANEW = (layout.RAW, layout.OVERVIEW)


def finish_run(path: Path, *, now: str) -> int:
    """Finish a run file and return how many samples of each channel it holds.

    The new file takes the place of the old one in one step. Where part of a chunk reached the disk for some
    channels only, the old file is kept beside it, with `.unfinished` after its name.

    Parameters
    ----------
    path
        Run file that nobody writes to any more.
    now
        ISO 8601 date and time, kept as `recovered_at`.

    Raises
    ------
    FileError
        It cannot be read, was closed in order, or the folder cannot be written; then it is as it was.
    """
    with rewritten(path, "it cannot be finished") as (source, target):
        if hdf5.number(source.attrs, "complete") != 0.0:
            raise FileError(f"{path} was closed in order: there is nothing to recover.")
        raw = hdf5.dataset(source, layout.RAW, path, (2,))
        count = layout.sample_count(source)
        hdf5.copy_attributes(source, target)
        for name in source:
            if name not in _MADE_ANEW:
                source.copy(name, target)
        _copy_samples(raw, target, count, path)
        hdf5.put_text(target.attrs, "recovered_at", now)
        hdf5.seal(target.attrs)
        if count < raw.shape[1]:
            _keep(path)
    return count


def _copy_samples(raw: Any, target: Any, count: int, path: Path) -> None:
    """Copy what is whole, and check that it reads back the same."""
    n_channels = raw.shape[0]
    copy = layout.make_raw(target, (n_channels, count), raw.dtype, raw.chunks or (1, layout.LARGEST_CHUNK))
    hdf5.copy_attributes(raw, copy)
    hdf5.seal(copy.attrs)
    overview, crcs, copied = OverviewMaker(n_channels, raw.dtype), [0] * n_channels, [0] * n_channels
    for place in layout.stored_pieces(raw, count):
        piece = copy[:, place] = raw[:, place]
        crcs = hdf5.rows_crc(piece, crcs)
        copied = hdf5.rows_crc(np.asarray(copy[:, place]), copied)
        overview.add(piece)
    if crcs != copied:
        raise FileError(f"{path} cannot be finished: the copy differs from the original, which is as it was.")
    write_overview(target, overview, layout.stored_unit(layout.read_digitisation(copy, path)))
    layout.write_end(target, count, crcs, complete=True)


def _keep(path: Path) -> None:
    names = (f"{path.name}{'' if number == 1 else f'-{number}'}{ASIDE}" for number in itertools.count(1))
    aside = next(aside for name in names if not (aside := path.with_name(name)).exists())
    try:
        os.link(path, aside)
    except OSError:
        # not every disk gives a file two names
        shutil.copy2(path, aside)


PRIOR, DECISIONS, FINDINGS, FINDING, SETUP = "front_end_prior", "decisions", "findings", "finding", "setup_posterior"
LIKELIHOOD, SETUP_PRIOR = "setup_likelihood", "setup_prior"
_UNITS = {"_rad": "rad", "_m_s2": "m/s^2", "_m_s": "m/s", "_m": "m", "_s": "s"}
"""By the end of a name, the longest first."""
ARRAYS: Mapping[str, Mapping[str, DTypeLike]] = {
    # for display, as the phase, which the path lengths give in full
    "corrected": {"i": np.float32, "q": np.float32},
    "paths": {"phase_rad": np.float32, "change_m": float, "u_m": float, "valid": bool, "piece": np.int32},
    "track": {"time_s": float, "position_m": float, "u_position_m": float, "valid": bool, "u_combined_m": float},
    "motion": {
        **dict.fromkeys(("time_s", "position_m", "velocity_m_s", "acceleration_m_s2"), float),
        **dict.fromkeys(("u_position_m", "u_velocity_m_s", "u_acceleration_m_s2"), float),
        "flight": np.int32,
    },
}
"""What is stored of the parts of a result, by field, and as what; a field that is None is left out."""
_KEPT_PARTS = ("bounces", layout.THUMBNAIL)
"""Of earlier results the figures are kept; track and paths can be computed again from the setup beside them."""


def write_results(path: Path, result: RunResult, *, health: Mapping[str, object] | None = None) -> None:
    """Store a result beside the samples of a run, in place of an older one, whose figures are kept (`stored_results`).

    The file is written anew under another name and put in place in one step: a crash meanwhile leaves the
    recording as it was, and replaced results do not make the file grow.

    Parameters
    ----------
    path
        Run file.
    result
        What the run gave.
    health
        Facts to add to the health record of the run.

    Raises
    ------
    FileError
        The run cannot be read, is being recorded, or the folder cannot be written; the recording is as it was.
    """
    with rewritten(path, "the results cannot be saved") as (source, target):
        _want_ended(source.attrs, path)
        hdf5.copy_attributes(source, target)
        for name in source:
            if name != layout.RESULTS:
                source.copy(name, target)
        keep_earlier(source, target, (__version__, dump_setup(result.setup)))
        _write(target.create_group(layout.RESULTS), result, source.attrs.get("crc32"))
        if health is not None:
            put_health(target, {**(health_in(source) or {}), **health})


def keep_earlier(source: Any, target: Any, same_as: tuple[str, str]) -> None:
    """Keep the figures of the results in `source` among the earlier ones of `target`.

    Parameters
    ----------
    source, target
        Opened run files; the earlier results of the source are in the target already.
    same_as
        Version and setup of the results that come in their place: those of the same are replaced, not kept.
    """
    old = sound_results(source)
    if old is None:
        return
    if made_by(old) in (same_as, *map(made_by, target.get(layout.EARLIER, {}).values())):
        return
    earlier = target.require_group(layout.EARLIER)
    # counted on from the last: names sort in the order of their making
    group = earlier.create_group(f"{max((int(name) for name in earlier), default=0) + 1:06d}")
    hdf5.copy_attributes(old, group)
    for name in _KEPT_PARTS:
        if name in old:
            source.copy(old[name], group, name=name)


def made_by(group: Any) -> tuple[str, str]:
    """Return version and setup (TOML) that a group of results was made by."""
    return hdf5.text(group.attrs, "version"), hdf5.text(group.attrs, "setup")


def _want_ended(attributes: Any, path: Path) -> None:
    """Refuse a file that a recorder may still be writing: what it writes from now on would be lost."""
    if hdf5.number(attributes, "complete") == 0.0 and "crc32" not in attributes:
        raise worded(FileError, "not_ended", path=path)


def results_are_current(path: Path, setup: Setup) -> bool:
    """Return whether a run holds sound, final results that this version made of its samples with this setup.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        results = sound_results(file)
        summary = {} if results is None else summary_in(results)
        return bool(summary) and not summary.get("preliminary") and are_made_of(file, setup)


def are_made_of(file: Any, setup: Setup) -> bool:
    """Return whether this version made the results in an opened run file, of the samples in it, with this setup."""
    attributes = file[layout.RESULTS].attrs
    crc = np.ravel(attributes.get("raw_crc32", ()))
    return (
        hdf5.text(attributes, "version") == __version__
        and hdf5.number(attributes, "format_version") == layout.RESULTS_VERSION
        and hdf5.text(attributes, "setup") == dump_setup(setup)
        and crc.size > 0
        and crc.tolist() == np.ravel(file.attrs.get("crc32", ())).tolist()
    )


def _write(group: Any, result: RunResult, raw_crc32: Any) -> None:
    summary = summarise(result)
    excerpt, channels = result.recording.excerpt, result.corrected.channels if result.corrected else ()
    tables = {
        # the warnings stand beside it
        "summary": {key: value for key, value in summary.items() if key != "warnings"},
        "warnings": result.warnings,
        "uncertainty_budget": result.uncertainty_budget,
        SETUP: result.setup_posterior,
        LIKELIHOOD: _likelihood_document(result),
        SETUP_PRIOR: result.setup_prior,
        "channels": [{**one.document(), FINDING: one.finding and one.finding.document()} for one in channels],
        FINDINGS: [one.document() for one in result.findings],
        DECISIONS: result.corrected.decisions if result.corrected else (),
        PRIOR: result.front_end_prior,
        "excerpt": excerpt,
    }
    attributes = {key: str(summary[key]) for key in ("version", "correction", "geometry", "status", "reason")}
    attributes |= {key: json.dumps(value, default=asdict) for key, value in tables.items()}
    attributes |= {"setup": dump_setup(result.setup), "processed_at": datetime.now(UTC).isoformat(timespec="seconds")}
    hdf5.put_all(group.attrs, {"format_version": layout.RESULTS_VERSION, "raw_crc32": raw_crc32, **attributes})
    group.attrs["first_sample"] = 0 if excerpt is None else excerpt.first_stored
    if result.segment is not None:
        group.attrs["segment"] = astuple(result.segment)
    hdf5.seal(group.attrs)
    put_bounces(group, result.bounces)
    _write_arrays(group, result, layout.chunk_length(result.recording.digitisation.sample_rate_hz))
    put_thumbnail(group, result)


def _likelihood_document(result: RunResult) -> dict[str, object] | None:
    found = result.setup_likelihood
    if found is None:
        return None
    keys = [one.key for one in unknown_inputs(result.setup)[0]]
    return {"keys": keys, "matrix": found.matrix.tolist(), "vector": found.vector.tolist()}


def _write_arrays(group: Any, result: RunResult, chunk: int) -> None:
    for part, kinds in ARRAYS.items():
        if (values := getattr(result, part)) is None:
            continue
        below = group.require_group(part)
        for name, kind in kinds.items():
            if (array := getattr(values, name)) is not None:
                unit = next((unit for end, unit in _UNITS.items() if name.endswith(end)), "1")
                hdf5.store(below, name, np.asarray(array, kind), chunk, unit=unit)


_NAME = "bounces"
_BESIDE = ("normal", "u_tilt_deg", "braked_1_m", "walls_s", "with_walls_s")
"""What is found beside impacts and fall: attributes of the table of impacts."""
_METHOD_BYTES = 40  # in UTF-8: rows of a table are of one length, longer names are cut (chosen by hand)
_BOUNCE_UNITS = (
    *("s", "m/s", "m/s", "1", "1", "text", "1", "1", "1", "1"),
    *("m", "m", "m", "m", "m/s", "m/s", "deg", "deg", "m/s", "m/s", "1", "1", "1", "1", "1", "1"),
)
_KINDS: dict[type, Any] = {float: "<f8", bool: "?", str: h5py.string_dtype("utf-8", _METHOD_BYTES)}
BOUNCE_TYPE = np.dtype([(name, _KINDS[kind]) for name, kind in get_type_hints(Bounce).items()])


def put_bounces(group: Any, bounces: Bounces) -> None:
    """Store bounces in a group of results."""
    rows = np.array([_row(bounce) for bounce in bounces.impacts], dtype=BOUNCE_TYPE)
    # compressed for the checksum that comes with it: a damaged figure is refused, not shown
    options = {"chunks": rows.shape, **hdf5.COMPRESSION} if rows.size else {}
    table = group.create_dataset(_NAME, data=rows, **options)
    found = asdict(bounces.free_fall) if bounces.free_fall else {}
    found |= {key: getattr(bounces, key) for key in _BESIDE}
    numbers = {key: np.asarray(value) for key, value in found.items() if value is not None and np.size(value)}
    hdf5.put_all(table.attrs, {"units": _BOUNCE_UNITS, **numbers})
    hdf5.seal(table.attrs)


def bounces_in(group: Any, path: Path) -> Bounces:
    """Return the bounces in a group of results.

    Raises
    ------
    FileError, KeyError, TypeError, ValueError
        They are damaged.
    """
    table = hdf5.dataset(group, _NAME, path, (1,))
    known = table.attrs
    if not hdf5.is_sound(known):
        raise ValueError
    fall = FreeFall(**{one.name: _value(known, one.name) for one in fields(FreeFall)}) if "g_m_s2" in known else None
    # nothing where there is nothing to say, or a version wrote them that knew nothing of it
    beside = {key: _value(known, key) for key in _BESIDE if key in known}
    return Bounces(tuple(map(_bounce, table[:])), fall, **beside)


def _value(attributes: Any, key: str) -> Any:
    value = np.asarray(attributes[key], dtype=np.float64).tolist()
    return tuple(value) if isinstance(value, list) else value


def _row(bounce: Bounce) -> tuple[Any, ...]:
    values = asdict(bounce) | {"method": layout.fitted(bounce.method, _METHOD_BYTES)}
    return tuple(values[str(name)] for name in BOUNCE_TYPE.names or ())


def _bounce(row: Any) -> Bounce:
    # an older version knew fewer
    known = set(row.dtype.names).intersection(BOUNCE_TYPE.names or ()) - {"method"}
    values = {name: row[name].item() for name in known}
    return Bounce(**values, method=bytes(row["method"]).decode("utf-8", "replace"))
