"""Write setup-file.md and setup.schema.json: every key of the setup file as the program itself knows it.

python docs/make_setup_reference.py
"""

from __future__ import annotations

import inspect
import json
import re
from pathlib import Path
from typing import get_args

from radargui.model.section import Section
from radargui.model.setup import Setup
from radargui.model.setup_error import find_place, value_text

HEAD = """# The setup file

Written by `docs/make_setup_reference.py` from the program's own models: what stands here is what it allows. The
README shows a whole file; `resources/setups/` holds ready ones. Lengths are in metres, angles in degrees; every `u_`
is a standard uncertainty. Where one of antennas, sphere, floor, frequency or clock is left out, the results assume a
laboratory's (`radargui/model/assumed.py`) and say so. All tables but `[radar]`, `[transmitter]` and `[[receiver]]`
may be left out.
"""


def reference() -> str:
    """Return the reference as Markdown."""
    parts = [HEAD]
    for name, info in Setup.model_fields.items():
        key = info.alias or name
        place = find_place(Setup, (key,))
        if place is None or not place.is_table:
            continue
        table = get_args(info.annotation)[0] if place.is_list else info.annotation
        parts.append(f"\n## {f'[[{key}]]' if place.is_list else f'[{key}]'}\n\n{_first_line(table)}\n")
        parts.append("\n| key | allowed | left out | meaning |\n|---|---|---|---|\n")
        meanings = _meanings(table)
        for one, field in table.model_fields.items():
            inner = find_place(Setup, (key, 0, one) if place.is_list else (key, one))
            default = "needed" if field.is_required() else "" if field.default is None else value_text(field.default)
            allowed = inner.allowed() if inner else ""
            parts.append(
                f"| `{one}` | {allowed} | {default} | {_meaning(one, meanings)} |\n".replace(" |v| v", " \\|v\\| v")
            )
    return "".join(parts)


def _meaning(key: str, meanings: dict[str, str]) -> str:
    value = key.removeprefix("u_")
    return f"Of `{value}`." if key != value and meanings.get(value) == meanings.get(key) else meanings.get(key, "")


def _first_line(table: type[Section]) -> str:
    return (inspect.getdoc(table) or "").partition("\n\n")[0].replace("\n", " ")


def _meanings(table: type[Section]) -> dict[str, str]:
    """Return what the docstring says of each attribute; several that share a text share it here."""
    attributes = (inspect.getdoc(table) or "").partition("Attributes\n----------\n")[2]
    found = re.findall(r"^(\S[^\n]*)\n((?: +[^\n]*(?:\n|$))+)", attributes, re.MULTILINE)
    return {name: " ".join(text.split()) for names, text in found for name in names.split(", ")}


def schema() -> str:
    """Return the same as JSON schema, for editors and other programs."""
    return json.dumps(Setup.model_json_schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    (Path(__file__).parent / "setup.schema.json").write_text(schema(), encoding="utf-8", newline="\n")
    (Path(__file__).parent / "setup-file.md").write_text(reference(), encoding="utf-8", newline="\n")
