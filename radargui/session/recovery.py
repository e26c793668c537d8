"""Recovery: runs that a crash left unfinished are found and finished; nothing is lost or overwritten."""

from contextlib import closing, suppress
from datetime import datetime
from pathlib import Path

from radargui.files.rewriting import finish_run
from radargui.files.run_file import run_is_complete
from radargui.model.errors import FileError
from radargui.session.catalogue import Catalogue, RunLine
from radargui.session.info import FILE_NAME
from radargui.session.lock import SessionLock, owner_of
from radargui.session.session import Session

NOTHING = "nothing was recorded"


def unfinished_runs(data_folder: Path, index: Path | None = None) -> tuple[RunLine, ...]:
    """Return the runs below a folder that a crash, a kill or a failure left unfinished.

    Sessions that a program writes to now are left out.

    Parameters
    ----------
    data_folder
        Its sessions, at any depth; or one session.
    index
        See `Catalogue`.
    """
    with closing(Catalogue(data_folder, index)) as catalogue:
        catalogue.refresh()
        found = [line for line in catalogue.unfinished() if not line.problem]
    busy = {folder for folder in {line.path.parent for line in found} if owner_of(folder) is not None}
    return tuple(line for line in found if line.path.parent not in busy and not _complete(line.path))


def recover(run: Path, *, now: datetime) -> int:
    """Finish an unfinished run, mark it as recovered, and return how many samples of each channel it holds.

    One without any sample is set aside in its session.

    Parameters
    ----------
    run
        Run file.
    now
        Date and time with offset from UTC.

    Raises
    ------
    SessionError
        Another program writes to the session, or its folder cannot be written.
    FileError
        The run cannot be read, or was closed in order.
    """
    lock = SessionLock(run.parent)
    try:
        at = (now if now.tzinfo else now.astimezone()).isoformat(timespec="seconds")
        count = finish_run(run, now=at)
        if count == 0 and (run.parent / FILE_NAME).is_file():
            with closing(Session.open(run.parent)) as session:
                session.reject(run, NOTHING)
    finally:
        lock.release()
    return count


def _complete(path: Path) -> bool:
    with suppress(FileError):
        return run_is_complete(path)
    return True
