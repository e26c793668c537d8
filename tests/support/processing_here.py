"""Processing of finished runs without a process of its own, which takes a second to start and gives way to all else."""

from __future__ import annotations

from typing import Any

from radargui.experiment.finished import process_finished
from radargui.experiment.processing_apart import ProcessingApart


class ProcessingHere(ProcessingApart):
    """Processes in this process."""

    def start(self) -> None:
        """Nothing is to be started."""

    def process(self, *arguments: Any) -> Any:
        """Do a job."""
        return process_finished(*arguments)
