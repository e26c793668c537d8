"""Sessions below a folder, found with an index in memory."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from radargui.session.catalogue import IN_MEMORY, Catalogue, Query, SessionSummary

ALL = Query()


def look(catalogue: Catalogue, query: Query = ALL) -> tuple[SessionSummary, ...]:
    """Return what a catalogue finds after a look at the folders."""
    catalogue.refresh()
    return catalogue.find(query)


def find_sessions(data_folder: Path, query: Query = ALL) -> tuple[SessionSummary, ...]:
    """Return what a catalogue finds that keeps nothing."""
    with closing(Catalogue(data_folder, IN_MEMORY)) as catalogue:
        return look(catalogue, query)
