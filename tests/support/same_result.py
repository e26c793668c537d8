"""Two results compared value by value."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace

import numpy as np

from radargui.model.result import RunResult

DISPLAYED = {"i", "q"}
"""Stored in single precision."""
DERIVED = {"phase_rad", "u_phase_rad"}
"""Computed from what is stored."""


def assert_same_result(found: RunResult, wanted: RunResult) -> None:
    """Want equal numbers; I and Q equal to single precision."""
    assert (found.status, found.reason, found.segment) == (wanted.status, wanted.reason, wanted.segment)
    assert found.setup == wanted.setup
    _assert_same(replace(found, recording=wanted.recording), wanted, "result")
    _assert_same(found.recording, wanted.recording, "recording")


def _assert_same(found: object, wanted: object, name: str) -> None:
    if isinstance(wanted, np.ndarray):
        assert isinstance(found, np.ndarray)
        assert found.dtype == wanted.dtype, name
        if name in DISPLAYED:
            np.testing.assert_array_equal(found.astype(np.float32), wanted.astype(np.float32), err_msg=name)
        elif name in DERIVED:
            np.testing.assert_allclose(found, wanted, rtol=1e-14, err_msg=name)
        else:
            np.testing.assert_array_equal(found, wanted, err_msg=name)
    elif is_dataclass(wanted):
        assert type(found) is type(wanted), name
        for one in (one for one in fields(wanted) if one.compare):
            _assert_same(getattr(found, one.name), getattr(wanted, one.name), one.name)
    elif isinstance(wanted, tuple):
        assert isinstance(found, tuple)
        assert len(found) == len(wanted), name
        for one, other in zip(found, wanted, strict=True):
            _assert_same(one, other, name)
    else:
        np.testing.assert_equal(found, wanted, err_msg=name)
