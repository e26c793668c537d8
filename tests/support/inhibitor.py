"""Stand-ins for the system's program that holds sleep off while a command runs."""

from __future__ import annotations

from pathlib import Path

GRANTS = """#!/bin/sh
echo "$@" >> "{log}"
while [ "${{1#-}}" != "$1" ]; do shift; done
"$@"
echo released >> "{log}"
"""
REFUSES = "#!/bin/sh\necho 'Failed to inhibit: Access denied' >&2\nexit 1\n"
HANGS = "#!/bin/sh\nexec cat\n"


def inhibitor(folder: Path, text: str = GRANTS, name: str = "systemd-inhibit") -> Path:
    """Put the program into a folder for PATH; return where the one that grants writes what was asked, and its end."""
    folder.mkdir()
    log = folder.with_suffix(".log")
    program = folder / name
    program.write_text(text.format(log=log) if text is GRANTS else text, encoding="utf-8")
    program.chmod(0o755)
    return log
