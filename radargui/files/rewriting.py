"""Rewrite a run file and put it in place of the old one in one step, to change it or to finish it."""

import contextlib
import itertools
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from radargui.files import hdf5, run_layout as layout
from radargui.files.access import why
from radargui.files.overview import OverviewMaker, write_overview
from radargui.files.staged_file import StagedFile
from radargui.model.errors import FileError, worded

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
