"""The door for programmers: what is public, that it loads late, and that its arrays are the tables' numbers."""

from __future__ import annotations

import ast
import csv
import json
import subprocess
import sys
import types
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.gui_sessions import make_session
from support.stored_runs import SETUP, store_runs

import radargui
from radargui.files.formats import EXPORT_FORMATS, export_run
from radargui.processing.result_of_run import stored_or_computed
from radargui.report.report import write_report
from radargui.report.tables import write_tables
from radargui.session.session import Session

ROOT = Path(radargui.__file__).parent
PUBLIC = {
    *("Bounce", "BounceTable", "ChannelQuality", "FreeFall", "RadarGuiError", "Recording", "Result", "Run", "Setup"),
    *("__version__", "open_run", "process", "read_setup", "series"),
}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return store_runs(tmp_path_factory.mktemp("api") / "session", 1)[0]


@pytest.fixture(scope="module")
def result(path: Path) -> radargui.Result:
    return radargui.process(radargui.open_run(path))


def test_what_is_public_is_listed_typed_and_there() -> None:
    assert set(radargui.__all__) == PUBLIC
    stub = ast.parse((ROOT / "__init__.pyi").read_text(encoding="utf-8"))
    listed = next(ast.literal_eval(one.value) for one in stub.body if isinstance(one, ast.Assign))
    assert set(listed) == PUBLIC
    imported = {(one.module, name.name) for one in stub.body if isinstance(one, ast.ImportFrom) for name in one.names}
    assert {name for _, name in imported} == PUBLIC - {"__version__"}
    assert all(getattr(import_module(str(place)), name) is getattr(radargui, name) for place, name in imported)
    assert (ROOT / "py.typed").exists()
    assert set(dir(radargui)) >= PUBLIC
    for name in PUBLIC:
        assert getattr(radargui, name).__doc__, name


def test_a_series_is_what_the_report_says(tmp_path: Path) -> None:
    session = make_session(tmp_path, 4)
    found = radargui.series(session, model="constant")
    report = write_report(Session.open(session, write=False), stored_or_computed, tmp_path / "report")
    document = json.loads(report.json.read_text(encoding="utf-8"))
    assert found.sentence == document["sentence"]
    assert found.sessions[0].series.e.mean == document["series"]["e_first_bounce"]["mean"]
    assert {one.on for one in found.samples[0].dependences} == {"angle_deg", "diameter_m", "drop", "e_t"}
    with pytest.raises(radargui.RadarGuiError, match="'cubic'"):
        radargui.series(session, model="cubic")


def test_a_folder_or_nothing_is_no_run(path: Path) -> None:
    with pytest.raises(radargui.RadarGuiError, match="is a folder, not a file"):
        radargui.open_run(path.parent)
    with pytest.raises(radargui.RadarGuiError, match="no such file"):
        radargui.open_run(path.with_name("absent.bin"))


def test_a_name_that_is_not_there_is_said() -> None:
    with pytest.raises(AttributeError, match="no attribute 'frobnicate'"):
        radargui.frobnicate  # noqa: B018


def test_importing_it_loads_nothing_else() -> None:
    script = "import json, sys, radargui; print(json.dumps([*sys.modules]))"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    loaded = json.loads(ended.stdout)
    assert [name for name in loaded if name.startswith("radargui")] == ["radargui"]
    assert not {"numpy", "pydantic", "scipy", "h5py"} & set(loaded)


def test_the_arrays_are_the_numbers_of_the_tables(result: radargui.Result, tmp_path: Path) -> None:
    write_tables(result.details, tmp_path)
    with (tmp_path / "track.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert result.time_s.shape == (len(rows),)
    for shape, array in (((3, len(rows)), result.path_m), ((3, len(rows)), result.position_m)):
        assert array.shape == shape
    for array, names in (
        (result.path_m, ("L1_m", "L2_m", "L3_m")),
        (result.u_path_m, ("u_L1_m", "u_L2_m", "u_L3_m")),
        (result.position_m, ("x_m", "y_m", "z_m")),
        (result.u_position_m, ("ux_m", "uy_m", "uz_m")),
        (result.u_position_combined_m, ("ux_combined_m", "uy_combined_m", "uz_combined_m")),
    ):
        written = np.array([[float(row[name]) for row in rows] for name in names])
        np.testing.assert_allclose(array, written, rtol=0.0, atol=1e-9)
    assert [row["valid"] for row in rows] == [str(int(one)) for one in result.valid]
    with (tmp_path / "bounces.csv").open(encoding="utf-8") as file:
        bounces = list(csv.DictReader(file))
    assert len(result.bounces) == len(bounces) >= 2
    assert result.bounces["e"] == pytest.approx([float(row["e"]) for row in bounces], rel=1e-11, nan_ok=True)
    assert result.bounces[0].e == result.bounces["e"][0]


def test_it_measures_what_falls(result: radargui.Result) -> None:
    assert (result.status, result.reason, result.correction) == ("ok", "", "published")
    assert result.bounces[0].e == pytest.approx(SETUP.simulation.restitution, abs=3.0 * result.bounces[0].u_e)
    assert result.free_fall is not None
    assert result.free_fall.g_m_s2 == pytest.approx(9.81, abs=0.2)
    assert result.u_g_combined_m_s2 is not None
    assert result.u_g_combined_m_s2 >= result.free_fall.u_g_m_s2
    assert [one.verdict for one in result.channels] == ["good"] * 3


def test_other_settings_and_files_of_others(path: Path, tmp_path: Path) -> None:
    run = radargui.open_run(path)
    assert radargui.process(run, correction="ellipse", geometry="plane").correction == "ellipse"
    with pytest.raises(
        radargui.RadarGuiError, match=r"processing.correction = \"best\", allowed: joint, flights, adaptive"
    ):
        radargui.process(run, correction="best")
    table = tmp_path / "drop.csv"
    volts = run.recording.volts()
    names = ",".join(run.recording.digitisation.channel_names).replace("I1", "first")
    rows = np.vstack([run.recording.time_s(), volts]).T
    np.savetxt(table, rows, delimiter=",", header=f"time_s,{names}", comments="")
    with pytest.raises(radargui.RadarGuiError, match="brings no setup"):
        radargui.open_run(table)
    mapped = "I1=first,Q1=Q1,I2=I2,Q2=Q2,I3=I3,Q3=Q3"
    again = radargui.open_run(table, setup=run.setup, channels=mapped)
    np.testing.assert_allclose(again.recording.volts(), volts)


def test_a_run_is_one_whatever_it_is_named(path: Path, tmp_path: Path) -> None:
    other = tmp_path / "run.HDF5"
    other.write_bytes(path.read_bytes())
    np.testing.assert_array_equal(radargui.open_run(other).recording.raw, radargui.open_run(path).recording.raw)


def test_what_was_exported_brings_its_own_setup(path: Path, tmp_path: Path) -> None:
    (table,) = export_run(path, EXPORT_FORMATS["csv"], tmp_path)
    assert radargui.open_run(table).setup == radargui.open_run(path).setup


def test_nothing_that_moves_is_an_answer(path: Path) -> None:
    run = radargui.open_run(path)
    still = run.recording.raw[:, :400]
    quiet = radargui.Run(type(run.recording)("still", still, run.recording.digitisation), run.setup)
    result = radargui.process(quiet)
    assert (result.status, len(result.bounces), result.free_fall, result.channels) == ("no_motion", 0, None, ())
    assert result.u_g_combined_m_s2 is None
    assert np.isnan(result.position_m).all()
    assert not result.valid.any()


class Table(dict[str, Any]):
    """Stands for a data frame: a dictionary of columns."""

    def __init__(self, data: Any, columns: list[str] | None = None) -> None:
        rows = isinstance(data, list)
        super().__init__({name: [row[name] for row in data] for name in columns or ()} if rows else data)


def test_views_are_made_where_the_package_is_there(result: radargui.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=Table))
    monkeypatch.setitem(sys.modules, "xarray", types.SimpleNamespace(Dataset=lambda *given: given))
    frame: Any = result.to_pandas()
    assert list(frame)[:4] == ["time_s", "L1_m", "L2_m", "L3_m"]
    np.testing.assert_array_equal(frame["z_m"], result.position_m[2])
    np.testing.assert_array_equal(result.bounces.to_pandas()["e"], result.bounces["e"])
    data: Any
    data, coordinates, attributes = result.to_xarray()  # type: ignore[misc]
    for dimensions, values in data.values():
        assert tuple(len(coordinates[one]) for one in dimensions) == values.shape
    assert attributes["status"] == "ok"


def test_a_view_whose_package_is_missing_says_what_to_install(
    result: radargui.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(radargui.RadarGuiError, match=r"Install radargui\[views\]"):
        result.to_xarray()
