"""The child that the system ends: the command line records in real time and tells each sample it has read.

python -m support.ended_child DESCRIPTOR here|apart ARGUMENT...

`apart` processes in a process of its own, as the command does; to start it takes as long as all the rest.
"""

from __future__ import annotations

import os
import struct
import sys

from support.killing import hear_signals

from radargui.cli import record
from radargui.cli.app import app
from radargui.cli.console import guarded
from radargui.experiment import series
from radargui.experiment.processing_apart import ProcessingHere
from radargui.model.recording import Block
from radargui.model.setup import Setup
from radargui.sources.simulated.model import SimulatedSource


class TellingSource(SimulatedSource):
    """Tells how many samples were read, before anybody gets them."""

    def __init__(self, setup: Setup, descriptor: int) -> None:
        super().__init__(setup, realtime=True)
        self._descriptor = descriptor

    def read(self) -> Block | None:
        block = super().read()
        if block is not None:
            os.write(self._descriptor, struct.pack("<q", block.end_index))
        return block


def main() -> None:
    hear_signals()
    descriptor = int(sys.argv[1])
    record.make_source = lambda _kind, setup, **_: TellingSource(setup, descriptor)
    if sys.argv[2] == "here":
        series.ProcessingApart = ProcessingHere  # type: ignore[misc]
    raise SystemExit(guarded(app, sys.argv[3:]))


if __name__ == "__main__":
    main()
