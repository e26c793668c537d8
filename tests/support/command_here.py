"""The command line in a process of its own that processes its runs itself: a second process takes a second to start.

python -m support.command_here ARGUMENT...
"""

from __future__ import annotations

from radargui.cli import main
from radargui.experiment import series
from radargui.experiment.processing_apart import ProcessingHere

if __name__ == "__main__":
    series.ProcessingApart = ProcessingHere  # type: ignore[misc]
    main()
