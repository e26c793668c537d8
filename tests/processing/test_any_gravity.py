"""Drops where g is another than on Earth: a drop tower, a counterweight."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from benchmarks.gate.worker import setup_of_version
from benchmarks.world.kinds import draw
from benchmarks.world.population import PopulationRecord

from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process

G_M_S2 = 3.0
DROP = {
    "rate_hz": 10000.0,
    "height_m": 0.12,
    "e": 0.6,
    "snr_db": 35.0,
    "walls": 0,
    "floor": 0.1,
    "told": True,
    "exact": True,
    "amplitude_v": 0.5,
    "density_kg_m3": 7850.0,
    "density_told": True,
}
BLAMES_GRAVITY = {"g_impossible", "clock_wrong", "setup_contradicted", "no_flights", "falls_otherwise"}


def dropped(true_m_s2: float, site: dict[str, float], correction: str) -> tuple[PopulationRecord, RunResult]:
    """Return a drop under one g and its result by a setup that states a site."""
    scene = draw("modelled", 48, 0, {**DROP, "gravity_m_s2": true_m_s2})
    tables: dict[str, Any] = {**scene.setup, "site": site, "processing": {"correction": correction}}
    setup: Setup = setup_of_version(tables)[0]
    record = scene.record()
    return record, process(record.recording, setup)


@pytest.mark.parametrize(
    ("correction", "error_m", "error_e"),
    [
        ("published", 5e-3, 0.02),
        ("flights", 1e-3, 2e-3),
        pytest.param("joint", 1e-3, 1e-3, marks=pytest.mark.slow),
    ],
)
def test_a_drop_under_a_third_of_g_is_measured_as_any_other(correction: str, error_m: float, error_e: float) -> None:
    record, result = dropped(G_M_S2, {"g_m_s2": G_M_S2, "u_g_m_s2": 0.003}, correction)
    assert result.status == "ok"
    assert result.corrected is not None
    assert result.corrected.method == correction
    assert not {one.code for one in result.findings} & BLAMES_GRAVITY
    assert record.position_m is not None
    assert result.track is not None
    known = result.track.valid & np.isfinite(result.track.position_m).all(axis=0)
    off = (result.track.position_m - record.position_m)[:, known]
    assert np.sqrt((off**2).sum(axis=0).mean()) < error_m
    fall = result.bounces.free_fall
    assert fall is not None
    assert fall.g_m_s2 == pytest.approx(G_M_S2, rel=0.03)
    first, true = result.bounces.impacts[0], record.impacts[0]
    assert first.valid
    assert first.time_s == pytest.approx(true[0], abs=1e-3)
    assert first.e == pytest.approx(true[3], abs=error_e)


@pytest.mark.parametrize(("true_m_s2", "stated_m_s2"), [(9.81, G_M_S2), (G_M_S2, 9.81)])
@pytest.mark.parametrize("correction", ["published", pytest.param("flights", marks=pytest.mark.slow)])
def test_a_site_that_states_another_g_is_told(correction: str, true_m_s2: float, stated_m_s2: float) -> None:
    _, result = dropped(true_m_s2, {"g_m_s2": stated_m_s2, "u_g_m_s2": 0.003}, correction)
    assert {one.code for one in result.findings} & BLAMES_GRAVITY
    assert not any(one.valid for one in result.bounces.impacts)
