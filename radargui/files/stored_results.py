"""The results stored with a run, the present ones and those before, to be compared."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.rewriting import copy_attribute
from radargui.files.run_header import is_run
from radargui.files.summary import summary_in
from radargui.files.thumbnail import Thumbnail, thumbnail_in
from radargui.model.errors import FileError
from radargui.model.setup import Setup
from radargui.model.setup_file import parse_setup

_KEPT_PARTS = ("bounces", layout.THUMBNAIL)
"""Of earlier results the figures are kept; track and paths can be computed again from the setup beside them."""


@dataclass(frozen=True, slots=True)
class StoredResult:
    """What a run gave under one setup and version.

    Attributes
    ----------
    summary
        See `files.summary.summarise`.
    processed_at
        ISO 8601 date and time.
    version
        Of the program that made it.
    setup_toml
        The setup it was made with.
    is_present
        Whether it is the result that lists and reports show; else one before.
    thumbnail
        Height against time in a few points, or None.
    """

    summary: dict[str, object]
    processed_at: str
    version: str
    setup_toml: str = field(repr=False)
    is_present: bool
    thumbnail: Thumbnail | None = field(default=None, repr=False)

    @property
    def setup(self) -> Setup:
        """The setup it was made with.

        Raises
        ------
        SetupError
            It is not valid for this version.
        """
        return parse_setup(self.setup_toml, "setup in the results")


def read_stored_results(path: Path) -> tuple[StoredResult, ...]:
    """Return all results stored with a run, the oldest first, the present one last.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        earlier = file.get(layout.EARLIER, {})
        groups = [(earlier[name], False) for name in sorted(earlier)]
        groups += [(file[layout.RESULTS], True)] if layout.RESULTS in file else []
        return tuple(_result(group, path, is_present) for group, is_present in groups)


def keep_earlier(source: Any, target: Any, same_as: tuple[str, str]) -> None:
    """Keep the figures of the results in `source` among the earlier ones of `target`.

    Parameters
    ----------
    source, target
        Opened run files; the earlier results of the source are in the target already.
    same_as
        Version and setup of the results that come in their place: those of the same are replaced, not kept.
    """
    if layout.RESULTS not in source or not hdf5.is_sound(source[layout.RESULTS].attrs):
        return
    old = source[layout.RESULTS]
    known = [made_by(group) for group in target.get(layout.EARLIER, {}).values()]
    if made_by(old) == same_as or made_by(old) in known:
        return
    earlier = target.require_group(layout.EARLIER)
    # counted on from the last: names sort in the order of their making
    group = earlier.create_group(f"{max((int(name) for name in earlier), default=0) + 1:06d}")
    for key in old.attrs:
        copy_attribute(old.attrs, group.attrs, key)
    for name in _KEPT_PARTS:
        if name in old:
            source.copy(old[name], group, name=name)


def made_by(group: Any) -> tuple[str, str]:
    """Return version and setup (TOML) that a group of results was made by."""
    return hdf5.text(group.attrs, "version"), hdf5.text(group.attrs, "setup")


def _result(group: Any, path: Path, is_present: bool) -> StoredResult:
    if not hdf5.is_sound(group.attrs):
        raise FileError(f"{path}: its results are damaged.", remedy="Process the run again.")
    version, setup_toml = made_by(group)
    return StoredResult(
        summary_in(group),
        hdf5.text(group.attrs, "processed_at"),
        version,
        setup_toml,
        is_present,
        thumbnail_in(group, path),
    )
