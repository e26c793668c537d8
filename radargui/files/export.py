"""Export: the run files of this program in formats that others open."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from radargui.files.csv_file import write_csv
from radargui.files.fresh_file import fresh_files, make_folder
from radargui.files.mat_file import write_mat
from radargui.files.progress import Progress, silent
from radargui.files.run_file import run_stream
from radargui.files.sigmf_file import write_sigmf
from radargui.files.tdms_file import write_tdms


@dataclass(frozen=True, slots=True)
class ExportFormat:
    """A format that runs are exported to.

    Attributes
    ----------
    name
        As the command line names it.
    title
        For people.
    suffixes
        Of the files that one run becomes.
    write
        Takes the run, one path a suffix, and what takes the share done.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    write: Callable[..., None]

    def paths(self, folder: Path, stem: str) -> tuple[Path, ...]:
        """Return the files that a run becomes in a folder."""
        return tuple(folder / (stem + suffix) for suffix in self.suffixes)


EXPORT_FORMATS: Mapping[str, ExportFormat] = {
    one.name: one
    for one in (
        ExportFormat("csv", "CSV", (".csv",), write_csv),
        ExportFormat("mat", "MATLAB", (".mat",), write_mat),
        ExportFormat("tdms", "NI TDMS", (".tdms",), write_tdms),
        ExportFormat("sigmf", "SigMF", (".sigmf-meta", ".sigmf-data"), write_sigmf),
    )
}


def export_run(
    path: Path,
    kind: ExportFormat,
    folder: Path,
    *,
    session: Mapping[str, str] | None = None,
    force: bool = False,
    report: Progress = silent,
) -> tuple[Path, ...]:
    """Write a run file in another format and return the files made; the run itself is only read.

    Parameters
    ----------
    path
        Run file.
    kind
        One of `EXPORT_FORMATS`.
    folder
        Where the files go, made where it is not there; they are named as the run.
    session
        Facts of its session that shall travel with it.
    force
        Whether files that are there are replaced.
    report
        Called with the share done.

    Raises
    ------
    FileError
        The run cannot be read, the files cannot be written, or one is there already.
    """
    paths = kind.paths(folder, path.stem)
    with run_stream(path, session) as run:
        make_folder(folder)
        with fresh_files(paths, force=force) as partial:
            kind.write(run, *partial, report)
    return paths
