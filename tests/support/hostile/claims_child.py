"""The watched process that reads every file of `claims`: each must be refused in one line.

python -m support.hostile.claims_child FOLDER [NAME]
"""

from __future__ import annotations

import faulthandler
import json
import sys
import traceback
import warnings
from pathlib import Path

from support.hostile.claims import CLAIMS
from support.hostile.victims import VICTIMS
from support.hostile.watch import Watch, limit_memory
from support.work import python_calls

from radargui.model.errors import RadarGuiError

LONGEST_S = 30.0
_KINDS = {".h5": "run", ".toml": "setup file", ".json": "session record"}


def main(folder: Path, only: str | None) -> None:
    """Read them and print a line of JSON for each: name, outcome, text, calls of functions it took."""
    warnings.simplefilter("ignore")
    paths = {}
    for name, make in CLAIMS.items():
        if only in (None, name):
            (folder / name).mkdir()
            paths[name] = make(folder / name)
    for kind in ("run", "run as a recording", "mat v5", "mat 7.3", "tdms", "sigmf archive", "csv", "setup file"):
        # Read once whole: all libraries are loaded then.
        (folder / kind).mkdir()
        VICTIMS[kind].read(VICTIMS[kind].make(folder / kind))
    watch = Watch(folder)
    limit_memory()
    for name, path in paths.items():
        answer: list[str] = []

        def read(path: Path = path, answer: list[str] = answer) -> None:
            answer.extend(_read(path, watch))

        calls = python_calls(read)
        print(json.dumps([name, *answer, calls]), flush=True)


def _read(path: Path, watch: Watch) -> tuple[str, str]:
    faulthandler.dump_traceback_later(LONGEST_S, exit=True)
    try:
        with watch:
            VICTIMS[_KINDS.get(path.suffix, "csv")].read(path)
    except RadarGuiError as error:
        return "refused", str(error)
    except BaseException:  # noqa: BLE001  that is what is looked for
        return "bad", traceback.format_exc()
    else:
        return "read", ""
    finally:
        faulthandler.cancel_dump_traceback_later()


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), sys.argv[2] if len(sys.argv) > 2 else None)
