"""The child that is killed: records a simulated drop in real time and tells each sample it has read.

python -m support.killed_child SETUP FOLDER
"""

from __future__ import annotations

import os
import struct
import sys
from datetime import UTC, datetime
from pathlib import Path

from support.one_run import record_run

from radargui.experiment.series import Experiment
from radargui.model.recording import Block
from radargui.model.setup import read_setup
from radargui.session.session import Session
from radargui.sources.simulated.model import SimulatedSource

SECONDS = 30.0


class TellingSource(SimulatedSource):
    """Tells how many samples were read, before anybody gets them."""

    def read(self) -> Block | None:
        block = super().read()
        if block is not None:
            os.write(1, struct.pack("<q", block.end_index))
        return block


def main() -> None:
    setup = read_setup(Path(sys.argv[1]))
    session = Session.create(Path(sys.argv[2]), setup, operator="child", now=datetime.now(UTC))
    source = TellingSource(setup, realtime=True)
    record_run(Experiment(setup, lambda _: source, session, seconds=SECONDS, process=False, live=False))


if __name__ == "__main__":
    main()
