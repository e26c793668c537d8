"""The setup file: TOML in, TOML out, the user's comments kept."""

import os
import re
import tomllib
from pathlib import Path
from typing import Any

import tomlkit
from pydantic import ValidationError
from tomlkit.exceptions import TOMLKitError

from radargui.model.errors import SetupError
from radargui.model.setup import Setup
from radargui.model.setup_error import describe

MOST_KEY_PARTS = 32
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_ENDLESS_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_KEY_PARTS}}}")


def load_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        Not TOML, or nested or long beyond all use; the text says where.
    """
    # The parser's memory grows with the square of the number of parts of a key.
    if _ENDLESS_KEY.search(text):
        raise ValueError("a key of too many parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError("tables or lists nested too deep") from None
    except ValueError:
        raise ValueError("a number has too many digits") from None


MAXIMUM_BYTES = 1_000_000


def parse_setup(text: str, name: str = "setup") -> Setup:
    """Return the setup that a TOML text describes.

    Raises
    ------
    SetupError
        Not TOML, or a key missing, unknown or out of range; one line names key, value and allowed range.
    """
    try:
        document = load_toml(text)
    except ValueError as error:
        raise _not_toml(name, str(error)) from None
    return validate_setup(document, name)


def validate_setup(document: dict[str, Any], name: str = "setup") -> Setup:
    """Return the setup that plain tables describe.

    Raises
    ------
    SetupError
        A key missing, unknown or out of range; one line names key, value and allowed range.
    """
    try:
        return Setup.model_validate(document)
    except ValidationError as error:
        raise SetupError(f"{name}: {describe(error, Setup)}") from None


def _not_toml(name: str, fault: str) -> SetupError:
    text = " ".join(fault.split())
    return SetupError(f"{name} is not TOML: {text}.", remedy="Correct that place or start from a shipped setup.")


def read_setup(path: Path) -> Setup:
    """Return the setup in a file.

    Raises
    ------
    SetupError
        Unreadable, not TOML, or invalid.
    """
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise SetupError(f"{path} is larger than a setup file can be", remedy="Give the TOML file of a setup.")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise SetupError(f"{path}: {error.strerror or error}", remedy="Check the path of the setup file.") from None
    except UnicodeDecodeError:
        raise SetupError(f"{path} is not TOML: not UTF-8 text", remedy="Give the TOML file of a setup.") from None
    return parse_setup(text, str(path))


def dump_setup(setup: Setup, original: str = "") -> str:
    """Return the setup as TOML; where `original` is given its comments and order stay."""
    document = tomlkit.parse(original) if original else tomlkit.document()
    _update(document, plain(setup))
    return tomlkit.dumps(document)


def plain(setup: Setup) -> dict[str, Any]:
    """Return the setup as plain tables: what was set or differs from the default, nothing that is None."""
    whole = setup.model_dump(by_alias=True, exclude_none=True, mode="json")
    given = setup.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True, mode="json")
    explicit = setup.model_dump(by_alias=True, exclude_none=True, exclude_unset=True, mode="json")
    return {
        key: whole[key] if key in ("schema", "receiver") else _merged(given.get(key), explicit.get(key))
        for key in whole
        if key in given or key in explicit
    }


def _merged(first: Any, second: Any) -> Any:
    if isinstance(first, dict) and isinstance(second, dict):
        return {**second, **first}
    return first if first is not None else second


def _update(target: Any, source: dict[str, Any]) -> None:
    for key in [key for key in target if key not in source]:
        del target[key]
    for key, value in source.items():
        old = target.get(key)
        if isinstance(value, dict) and hasattr(old, "keys"):
            _update(old, value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            _update_tables(target, key, value)
        elif old is None or _unwrapped(old) != value:
            target[key] = value


def _unwrapped(item: Any) -> Any:
    """Return the plain value of an item; the library gives true and false plain already."""
    return item.unwrap() if hasattr(item, "unwrap") else item


def _update_tables(target: Any, key: str, rows: list[dict[str, Any]]) -> None:
    tables = target.get(key)
    if not hasattr(tables, "body") and not isinstance(tables, tomlkit.items.AoT):
        tables = tomlkit.aot()
        target[key] = tables
    tables = target[key]
    while len(tables) > len(rows):
        del tables[len(tables) - 1]
    for index, row in enumerate(rows):
        if index < len(tables):
            _update(tables[index], row)
        else:
            table = tomlkit.table()
            table.update(row)
            tables.append(table)


def write_setup(setup: Setup, path: Path) -> None:
    """Write the setup; comments of a file that is there survive, and the file is replaced in one step.

    Raises
    ------
    SetupError
        The folder cannot be written.
    """
    try:
        original = path.read_text(encoding="utf-8-sig") if path.exists() else ""
        text = dump_setup(setup, original)
    except (OSError, UnicodeDecodeError, TOMLKitError):
        text = dump_setup(setup)
    partial = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        raise SetupError(
            f"{path}: cannot be written: {error.strerror or error}", remedy="Choose another folder."
        ) from None
