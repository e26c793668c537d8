"""Live against offline where the path was lost on the way: its pieces have no common zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.one_receiver.generator import make_scene

from radargui.experiment.finished import LiveAgreement, live_agreement
from radargui.live.track import LiveSpan
from radargui.model.result import PathLengths, RunResult, Segment

N, LOST = 4000, slice(1900, 2100)


def agreement(live_m: np.ndarray, piece: np.ndarray | None) -> LiveAgreement | None:
    """Offline: a straight way of 0.4 m, lost in the middle, which begins anew at zero after it."""
    scene = make_scene(0, 0)
    recording = replace(scene.recording, raw=scene.recording.raw[:, :N])
    path = np.linspace(0.0, 0.4, N)[None]
    path[:, LOST.stop :] -= path[:, LOST.stop :][:, :1]
    valid = np.ones((1, N), dtype=np.bool_)
    valid[:, LOST] = False
    path[:, LOST] = np.nan
    paths = PathLengths(recording.time_s(), path, path, np.full_like(path, 1e-4), valid, piece)
    result = RunResult(recording, scene.setup, "ok", segment=Segment(0, N, 0, 0), paths=paths)
    index = np.arange(0, N, 10)
    nothing = np.full((3, index.size), np.nan)
    return live_agreement(
        LiveSpan(index, index / 1e4, nothing[:1], nothing[:1], live_m[None, index], nothing), 0, result
    )


def test_a_piece_is_compared_from_its_own_zero() -> None:
    live = np.linspace(0.0, 0.4, N) + 1e-4 * np.tile([1.0, 1.0, -1.0, -1.0], N // 4).repeat(10)[:N]
    piece = np.where(np.arange(N) < 2000, 0, 1)
    found = agreement(live, piece)
    assert found is not None
    assert found.rms_m == pytest.approx(1e-4, rel=0.1)
    joined = agreement(live, None)
    assert joined is not None
    assert joined.max_m > 0.2


def test_a_drift_within_a_later_piece_is_still_told() -> None:
    live = np.linspace(0.0, 0.4, N)
    live[LOST.stop :] *= 1.1
    found = agreement(live, np.where(np.arange(N) < 2000, 0, 1))
    assert found is not None
    assert found.max_m == pytest.approx(0.05 * 0.4 * 0.5, rel=0.1)
