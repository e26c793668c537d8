"""A receiver that only the correction finds wanting: of four it is left out, of three nothing is known."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.scoring.budget import with_correction
from benchmarks.world.broken.drops import Drop, make_drop
from benchmarks.world.disturbed.draw import disturbed
from benchmarks.world.disturbed.front_end import Dip
from benchmarks.world.scene import make_record

from radargui.model.result import RunResult
from radargui.processing.process import process


def drowned(n_receivers: int, receivers: tuple[int, ...]) -> tuple[Drop, RunResult]:
    """A drop in which white noise drowns some receivers: I and Q still show one echo, but no fringe can be counted."""
    drop = make_drop(3, "whole", n_receivers)
    rng = np.random.default_rng(1)
    raw = drop.recording.raw.astype(float)
    for receiver in receivers:
        pair = raw[2 * receiver : 2 * receiver + 2]
        pair += rng.normal(0.0, 1.2 * pair.std(), pair.shape)
    recording = replace(drop.recording, raw=np.round(raw).astype(np.int16))
    return drop, process(recording, with_correction(drop.setup, "ellipse"))


def test_four_receivers_go_on_without_the_one_that_the_correction_rejects() -> None:
    drop, result = drowned(4, (1,))
    assert result.status == "ok"
    assert result.corrected is not None
    assert [one.verdict for one in result.corrected.channels] == ["good", "rejected", "good", "good"]
    assert [warning for warning in result.warnings if "go on without" in warning] == [
        f"receiver 2: {result.corrected.channels[1].reason}: the others go on without it"
    ]
    assert result.track is not None
    moving = slice(*drop.moving)
    wrong_m = np.linalg.norm((result.track.position_m - drop.position_m)[:, moving], axis=0)
    assert np.median(wrong_m) < 1e-3
    assert result.paths is not None
    assert not result.paths.valid[1].any()


def test_of_three_receivers_none_can_be_left_out_and_nothing_is_valid() -> None:
    for n_receivers, receivers in ((3, (1,)), (4, (1, 2))):
        _, result = drowned(n_receivers, receivers)
        assert result.status == "rejected"
        for receiver in receivers:
            assert f"receiver {receiver + 1}: " in result.reason
        assert result.paths is not None
        assert not result.paths.valid.any()
        assert result.track is not None
        assert not result.track.valid.any()
        assert not result.bounces.impacts


@pytest.mark.slow
def test_a_loose_contact_of_15_ms_is_left_out_and_no_fringe_is_lost() -> None:
    scene = disturbed("steps/contact", 7101, "exact", strength=0.9, rate_hz=5000.0)
    record = make_record(scene)
    shares: list[float] = []
    result = process(record.recording, scene.setup, shares.append)
    assert result.status == "ok"
    assert result.corrected is not None
    assert result.corrected.method == "joint"
    assert [one for one in result.warnings if "receiver 1 shows from 0.7" in one and "left out" in one]
    assert result.track is not None
    known = result.track.valid & (result.track.time_s > scene.drop.start_s)
    wrong_m = np.linalg.norm(result.track.position_m - record.truth.position_m, axis=0)[known]
    # 25 mm with the contact counted as an echo
    assert wrong_m.max() < 1e-4
    # the second estimate, without the contact, is seen to go on from where the first one was
    assert shares == sorted(shares)
    assert np.diff([*shares, 1.0]).max() < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("over_the_impact", [False, True])
def test_a_dip_that_hardly_shows_in_the_misfit_is_left_out_and_told_by_its_time(over_the_impact: bool) -> None:
    scene = disturbed("dip/echo", 4200116, walls=0)
    (dip,) = scene.disturbances
    assert isinstance(dip, Dip)
    if over_the_impact:
        dip = replace(dip, begin_s=scene.drop.impacts[0].time_s - 0.008)
        scene = replace(scene, disturbances=(dip,))
    record = make_record(scene)
    result = process(record.recording, scene.setup)
    assert result.status == "ok"
    assert result.corrected is not None
    assert result.corrected.method == "joint"
    (told,) = [one for one in result.findings if one.code == "dip_left_out"]
    assert told.receiver == dip.receiver + 1
    begin_s, end_s = map(float, re.findall(r"[\d.]+", re.findall(r"from (.*) s what", told.text)[0]))
    assert begin_s == pytest.approx(dip.begin_s, abs=0.01)
    assert end_s == pytest.approx(dip.begin_s + dip.lasts_s, abs=0.01)
    # nothing else is blamed
    assert {one.receiver for one in result.findings} == {told.receiver}
    assert result.track is not None
    known = result.track.valid & (result.track.time_s > scene.drop.start_s)
    wrong_m = np.abs(result.track.position_m - record.truth.position_m)[:, known]
    assert (wrong_m < 2.0 * result.track.u_position_m[:, known]).mean() > 0.9
    assert wrong_m.max() < 1e-3


@pytest.mark.slow
def test_a_cable_that_comes_off_for_good_is_named() -> None:
    scene = disturbed("steps/lost", 7104, "exact", strength=0.9, rate_hz=5000.0)
    result = process(make_record(scene).recording, scene.setup)
    assert result.status == "rejected"
    assert "I2 stands still" in result.reason
