"""Export to MATLAB: v5 while it is small, 7.3 (HDF5) piece by piece where it is long."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.io import savemat

from radargui.files.mat73_writer import write_mat73
from radargui.files.mat_layout import CODES, SCALING, scaling_table, small_variables, variable_names
from radargui.files.progress import Progress
from radargui.files.run_stream import RunStream
from radargui.model.arrays import RawArray

LARGEST_V5_BYTES = 200_000_000
"""Volts and codes that are written as v5, for which all of them must be in memory."""


def write_mat(run: RunStream, path: Path, tell: Progress) -> None:
    """Write vectors `I1`, `Q1`, ... in volts (or the unit), `Fs` in Hz, `unit`, and all facts as TOML in `radargui`.

    A run of codes holds them untouched, too: `codes` (n_samples, n_channels, int16) and `scaling` (n_channels,
    n_coefficients), volts = sum over k of scaling(channel, k + 1) code^k.
    """
    facts = run.facts
    n_bytes = facts.n_samples * facts.digitisation.n_channels * 10
    if n_bytes > LARGEST_V5_BYTES:
        write_mat73(run, path, tell)
        return
    pieces = list(run.pieces())
    raw = cast("RawArray", np.hstack(pieces) if pieces else np.empty((facts.digitisation.n_channels, 0)))
    volts = facts.digitisation.volts(raw)
    content: dict[str, Any] = dict(zip(variable_names(facts), volts[:, :, None], strict=True))
    content |= small_variables(facts)
    if facts.digitisation.scaling is not None:
        content[CODES] = raw.T
        content[SCALING] = scaling_table(facts)
    tell(0.5)
    savemat(path, content, do_compression=True, appendmat=False, long_field_names=True)
    tell(1.0)
