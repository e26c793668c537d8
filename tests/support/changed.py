"""A setup with some keys changed, validated again."""

from __future__ import annotations

from typing import Any

from radargui.model.setup import Setup


def changed(setup: Setup, **tables: dict[str, Any]) -> Setup:
    """Return `setup` with keys of its tables replaced: changed(setup, processing={"correction": "none"})."""
    plain = setup.model_dump(by_alias=True)
    for name, keys in tables.items():
        plain[name] = {**plain[name], **keys}
    return Setup.model_validate(plain)
