"""The variables of an exported MATLAB file, v5 and 7.3 alike."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from radargui.files.export_facts import ExportFacts

FACTS, CODES, SCALING = "radargui", "codes", "scaling"
"""All facts as TOML text; codes (n_samples, n_channels); coefficients c_k of volts, a row a channel."""
_FIT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")


def variable_names(facts: ExportFacts) -> tuple[str, ...]:
    """Return the names of the channels, ch1, ch2, ... where one cannot be that of a variable."""
    names = facts.digitisation.channel_names
    taken = {*small_variables(facts), CODES, SCALING}
    if all(_FIT.fullmatch(name) and name not in taken for name in names):
        return names
    return tuple(f"ch{place}" for place in range(1, len(names) + 1))


def small_variables(facts: ExportFacts) -> dict[str, Any]:
    """Return the variables that hold single values and texts."""
    known = facts.digitisation
    return {
        "Fs": known.sample_rate_hz,
        "unit": known.unit,
        "channel_skew_s": known.channel_skew_s,
        "started_at": facts.started_at,
        FACTS: facts.text(),
    }


def scaling_table(facts: ExportFacts) -> Any:
    """Return the coefficients, shape (n_channels, n_coefficients), padded with zeros."""
    scaling = facts.digitisation.scaling or ()
    table = np.zeros((len(scaling), max((len(row) for row in scaling), default=0)))
    for row, coefficients in zip(table, scaling, strict=True):
        row[: len(coefficients)] = coefficients
    return table
