"""The watched process: reads damaged files; whatever is neither right nor a clear refusal is told on stdout.

python -m support.hostile.child FOLDER FIRST COUNT [KIND]
"""

from __future__ import annotations

import faulthandler
import json
import random
import sys
import traceback
import warnings
from pathlib import Path

from support.hostile.damage import damaged
from support.hostile.victims import VICTIMS, Victim
from support.hostile.watch import Watch, limit_memory

from radargui.model.errors import RadarGuiError

LONGEST_S = 20.0


def main(folder: Path, first: int, count: int, only: str | None) -> None:
    """Read `count` damaged files, seed `first` and following; the kinds take turns."""
    warnings.simplefilter("ignore")
    kinds = [only] if only else list(VICTIMS)
    places = {kind: folder / str(number) for number, kind in enumerate(kinds)}
    sound = {}
    for kind in kinds:
        places[kind].mkdir()
        path = VICTIMS[kind].make(places[kind])
        # Read once whole: all libraries are loaded then, and it is known to be readable.
        VICTIMS[kind].read(path)
        sound[kind] = (path, path.read_bytes())
    watch = Watch(folder)
    limit_memory()
    for seed in range(first, first + count):
        kind = kinds[seed % len(kinds)]
        path, content = sound[kind]
        chance = random.Random(seed)
        path.write_bytes(damaged(content, chance, is_text=VICTIMS[kind].is_text))
        print(json.dumps([seed, kind, *_read(VICTIMS[kind], path, watch)]), flush=True)


def _read(victim: Victim, path: Path, watch: Watch) -> tuple[str, str]:
    faulthandler.dump_traceback_later(LONGEST_S, exit=True)
    try:
        with watch:
            victim.read(path)
    except RadarGuiError as error:
        text = str(error)
        if "\n" in text or "does not fit into the memory" in text or len(text) > 3000:
            return "bad", text[:1000]
        return "refused", text
    except BaseException:  # noqa: BLE001  that is what is looked for
        return "bad", traceback.format_exc()
    else:
        return ("bad", "; ".join(watch.seen)) if watch.seen else ("read", "")
    finally:
        faulthandler.cancel_dump_traceback_later()


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4] if len(sys.argv) > 4 else None)
