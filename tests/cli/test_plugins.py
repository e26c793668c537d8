"""The worked plug-ins of docs/examples do what docs/plugins.md says of them, installed without a fork."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command_line import Command
from support.fake_clock import FakeClock
from support.gui_sessions import make_session
from support.laboratory import installed
from support.stored_runs import SETUP, store_runs

import radargui
from radargui.model.errors import RadarGuiError
from radargui.model.plugins import load_plugin, plugins
from radargui.model.setup import changed
from radargui.report.run_facts import added_pictures, take_facts
from radargui.report.run_section import run_page, run_section
from radargui.restitution.speed_models import ImpactPoint, fit_speed_models
from radargui.sources.factory import make_source, source_kinds


@pytest.fixture
def laboratory(tmp_path: Path) -> Iterator[None]:
    with installed(tmp_path):
        yield


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> radargui.Run:
    return radargui.open_run(store_runs(tmp_path_factory.mktemp("plugins") / "session", 1)[0])


def test_without_its_package_nothing_of_it_is_known() -> None:
    assert source_kinds() == ("simulated", "ni", "replay")
    with pytest.raises(RadarGuiError, match="'sawtooth' is no source"):
        make_source("sawtooth", SETUP)
    with pytest.raises(RadarGuiError, match="No plug-in 'largest-circle'"):
        load_plugin("corrections", "largest-circle")


@pytest.mark.usefixtures("laboratory")
def test_a_source_gives_blocks_until_it_is_stopped() -> None:
    clock = FakeClock()
    source = make_source("sawtooth", SETUP, clock=clock)
    digitisation = source.open()
    source.start()
    blocks = [source.read() for _ in range(5)]
    source.stop()
    assert source.read() is None
    samples = np.concatenate([block.samples for block in blocks if block is not None], axis=1)
    assert [block and block.first_index for block in blocks][1] == blocks[0].count  # type: ignore[union-attr]
    assert samples.shape[0] == digitisation.n_channels == 6
    turns = np.unwrap(np.arctan2(samples[1], samples[0])) / (2.0 * np.pi)
    assert turns[-1] == pytest.approx((samples.shape[1] - 1) / digitisation.sample_rate_hz / 0.1)


@pytest.mark.usefixtures("laboratory")
def test_a_source_is_recorded_from_the_command_line(command: Command, setup_file: Path, tmp_path: Path) -> None:
    ended = command("record", "--source", "sawtooth", "--seconds", "0.2", "--setup", setup_file, "--output", tmp_path)
    assert ended.status == 0, ended.err
    (path,) = tmp_path.glob("*/run-0001.h5")
    assert radargui.open_run(path).recording.digitisation.device == "sawtooth"
    assert command("record", "--source", "sawtooth", "--fast", "--setup", setup_file).status == 2


@pytest.mark.usefixtures("laboratory")
def test_a_correction_is_named_in_the_setup_and_measures(run: radargui.Run) -> None:
    assert changed(run.setup, {"processing.correction": "largest-circle"}).processing.correction == "largest-circle"
    result = radargui.process(run, correction="largest-circle")
    assert (result.status, result.correction) == ("ok", "largest-circle")
    # a scene without mismatch: its circle is the signal's
    assert result.bounces[0].e == pytest.approx(run.setup.simulation.restitution, abs=0.01)


@pytest.mark.usefixtures("laboratory")
def test_a_figure_stands_in_the_section_of_the_run(run: radargui.Run) -> None:
    result = radargui.process(run).details
    facts = take_facts(result, "run-0001")
    (brief,) = run_page(facts).pictures
    (picture,) = [one for one in run_section(facts, run.setup).pictures if one.title == brief.title]
    assert picture.title == "speed over time"
    (line,) = picture.draw().axes[0].lines
    fastest = max(bounce.speed_before_m_s for bounce in result.bounces.impacts)
    assert np.nanmax(line.get_ydata()) == pytest.approx(fastest, rel=0.1)


@pytest.mark.usefixtures("laboratory")
def test_a_law_is_fitted_beside_the_programs_own(
    command: Command, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    points = [ImpactPoint(f"{k}", v, 0.9 - 0.05 * v, 1e-3) for k, v in enumerate((0.5, 1.0, 1.7, 2.2, 2.6))]
    assert [fit.model for fit in fit_speed_models(points)] == ["constant", "power", "johnson", "viscoelastic", "line"]
    fit = fit_speed_models(points)[-1]
    assert [one.value for one in fit.parameters] == pytest.approx([0.9, 0.05], abs=1e-6)
    assert fit.words.startswith("line: e0 = ")
    session = make_session(tmp_path, 4)
    ended = command("report", session, "--output", tmp_path / "out", "--law", "line")
    assert ended.status == 0, ended.err
    assert "line (chosen)" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    refused = command("report", session, "--law", "cubic")
    assert (refused.status, "allowed: constant, power, johnson, viscoelastic, line" in refused.err) == (2, True)

    import laboratory.law as module

    def fails(_v: object, _e0: float, _b: float) -> object:
        raise ZeroDivisionError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "LINE", replace(module.LINE, e=fails))
        assert fit_speed_models(points)[-1].problem == "the plug-in failed: ZeroDivisionError"
        assert "The law line was left out" in caplog.text
        patch.setattr(module, "LINE", "no law")
        assert "is no SpeedModel" in fit_speed_models(points)[-1].problem


@pytest.mark.usefixtures("laboratory")
def test_one_that_fails_costs_nothing_else(
    run: radargui.Run, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    import laboratory.figure as figure

    def fail(_result: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(figure, "speed_over_time", fail)
    assert added_pictures(radargui.process(run).details) == ()
    assert "speed-over-time was left out" in caplog.text
    monkeypatch.delattr(figure, "speed_over_time")
    with pytest.raises(RadarGuiError, match=r"speed-over-time .* cannot be loaded: AttributeError"):
        load_plugin("figures", "speed-over-time")
    assert list(plugins("figures")) == ["speed-over-time"]
