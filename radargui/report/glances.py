"""What the stored results of sessions say, read once: a run is read again when its file changes."""

from pathlib import Path

from radargui.report.facts import SessionFacts
from radargui.report.run_facts import RunFacts, glance
from radargui.session.session import Session


class Glances:
    """Remembers what was read; for threads of work."""

    def __init__(self) -> None:
        self._known: dict[Path, tuple[int, RunFacts]] = {}

    def session_facts(self, session: Session) -> SessionFacts:
        """Return what a session found, without samples and without where it comes from."""
        return SessionFacts(session.info, tuple(self._facts(path, session) for path in session.run_paths()))

    def _facts(self, path: Path, session: Session) -> RunFacts:
        changed = path.stat().st_mtime_ns if path.exists() else 0
        known = self._known.get(path)
        if known is None or known[0] != changed:
            known = self._known[path] = changed, glance(path, session.setup.floor.normal)
        return known[1]
