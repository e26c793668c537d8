"""Paths that all change while the tracer hangs at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.accuracy import with_method
from benchmarks.world.disturbed.front_end import Oscillator
from benchmarks.world.draw import draw
from benchmarks.world.scene import make_record
from support.words import words

from radargui.model.arrays import ComplexArray
from radargui.model.result import Segment
from radargui.processing.by_estimate import drifting_rest
from radargui.processing.process import process

WAVELENGTH_M, REST_S = 0.03, 0.3
TIME_S = np.arange(3000) / 10_000.0
SEGMENT = Segment(3000, 3000, 0, 3000)


def said(point: ComplexArray) -> str:
    noise = np.random.default_rng(1).standard_normal((2, *point.shape))
    point = point + 0.008 * (noise[0] + 1j * noise[1])
    return words(drifting_rest(TIME_S, point, np.ones(point.shape, dtype=np.bool_), SEGMENT, WAVELENGTH_M))


def resting(*speeds_m_s: float) -> ComplexArray:
    phase = 2.0 * np.pi / WAVELENGTH_M * np.outer(speeds_m_s, TIME_S) + np.array([[0.4], [2.0], [-3.0]])
    return np.asarray(np.exp(1j * phase))


@pytest.mark.parametrize("m_s", [3e-4, -3e-4])
def test_paths_that_all_change_alike_at_rest_are_told(m_s: float) -> None:
    assert f"by {1e3 * m_s:+.2g} mm/s: the oscillator drifts (by 0.0002 of its" in said(
        resting(m_s, 0.9 * m_s, 1.1 * m_s)
    )


@pytest.mark.parametrize(
    "speeds_m_s",
    [
        (0.0, 0.0, 0.0),
        # some noise
        (2e-5, 2e-5, 2e-5),
        # a tracer that swings aside, or one receiver alone
        (3e-4, -3e-4, 3e-4),
        (3e-4, 0.0, 0.0),
    ],
)
def test_a_rest_is_one_where_not_all_paths_change_alike(speeds_m_s: tuple[float, ...]) -> None:
    assert said(resting(*speeds_m_s)) == ""


def test_offsets_that_drift_are_no_paths() -> None:
    drift = 0.2 * np.exp(1j * np.array([[0.4 + 0.8], [2.0 + 0.9], [-3.0 + 0.7]])) * TIME_S
    assert said(resting(0.0, 0.0, 0.0) + drift) == ""
    assert said(np.full((3, TIME_S.size), np.nan + 0j)) == ""


@pytest.mark.parametrize(("share_s", "is_told"), [(0.0, False), (2e-4, True)])
def test_an_oscillator_that_drifts_before_a_fall_is_told(share_s: float, *, is_told: bool) -> None:
    """2e-4 a second: g was 4.5 u off in silence."""
    scene = draw(7307000, "exact", snr_db=42.0, walls=0, rate_hz=5000.0)
    leaks = np.array([complex(*one.offset) for one in scene.mixers])
    drifting = Oscillator(scene.room, 0.0, 10.0, 10.0 * share_s, 0.3, leaks)
    record = make_record(replace(scene, disturbances=(drifting,)))
    result = process(record.recording, with_method(scene.setup, "adaptive-exact"))
    assert any("all paths change alike" in one for one in result.warnings) is is_told
