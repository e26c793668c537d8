"""Known trajectories: where they are, when they begin, and what is refused."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from radargui.calibration.known_path import KnownMotion, read_known
from radargui.model.errors import SetupError

PATHS = Path(__file__).parents[2] / "resources" / "paths"


def written(folder: Path, text: str) -> Path:
    path = folder / "path.toml"
    path.write_text(text)
    return path


def test_a_stage_goes_from_end_to_end_and_keeps_its_speed() -> None:
    stage = read_known(PATHS / "stage.toml")
    ends = stage.place(np.array([-1.0, stage.end_s + 1.0]))
    assert np.allclose(ends.T, [[0.05, 0.02, -0.05], [-0.03, 0.06, 0.10]])
    middle = stage.place(np.array([1.0, 1.5]))
    assert np.linalg.norm(middle[:, 1] - middle[:, 0]) == pytest.approx(0.5 * 0.05)


def test_steps_rest_between(tmp_path: Path) -> None:
    text = 'kind = "stage"\nfrom_m = [0, 0, 0]\nto_m = [0.1, 0, 0]\nspeed_m_s = 0.1\nsteps = 5\ndwell_s = 1.0\n'
    stage = read_known(written(tmp_path, text))
    assert np.allclose(stage.place(np.array([0.5, 1.1, 1.7]))[0], [0.02, 0.02, 0.04])


def test_a_turntable_stays_on_its_circle_and_turns_as_told() -> None:
    table = read_known(PATHS / "turntable.toml")
    place = table.place(np.linspace(0.0, table.end_s, 200)) - np.array([[0.03], [0.02], [0.0]])
    assert np.allclose(np.linalg.norm(place, axis=0), 0.06)
    assert np.allclose(np.array([0.0, 0.3, 1.0]) @ place, 0.0, atol=1e-15)
    # two whole turns: where it began
    assert np.allclose(place[:, -1], place[:, 0])
    assert np.allclose(place[:, 0], [0.06, 0.0, 0.0])


def test_an_encoder_tells_the_angle(tmp_path: Path) -> None:
    (tmp_path / "angles.csv").write_text("time_s,angle_deg\n0,0\n1,90\n2,180\n3,270\n")
    text = 'kind = "turntable"\ncentre_m = [0, 0, 0]\nradius_m = 0.1\nencoder = "angles.csv"\n'
    assert np.allclose(read_known(written(tmp_path, text)).place(np.array([1.0, 2.0])).T, [[0, 0.1, 0], [-0.1, 0, 0]])


def test_a_pendulum_swings_as_its_equation_says(tmp_path: Path) -> None:
    text = 'kind = "pendulum"\npivot_m = [0, 0, 0.4]\nlength_m = 0.4\namplitude_deg = 70.0\nswings = 5\n'
    time = np.linspace(0.0, 2.0, 50)
    pendulum = read_known(written(tmp_path, text))
    swing = solve_ivp(
        lambda _, y: [y[1], -9.81 / 0.4 * np.sin(y[0])], (0.0, 2.0), [np.radians(70.0), 0.0], t_eval=time, rtol=1e-10,
        atol=1e-12,
    )  # fmt: skip
    assert np.allclose(pendulum.place(time)[0], 0.4 * np.sin(swing.y[0]), atol=1e-8)


def test_a_motion_brings_velocity_and_acceleration_and_goes_to_other_processes() -> None:
    motion = pickle.loads(pickle.dumps(KnownMotion(read_known(PATHS / "pendulum.toml"), 0.3, 0.01)))
    own = np.array([one.value for one in motion.own])
    time = np.linspace(0.5, 1.5, 2001)
    series, ties = motion.at(time, {}, own)
    assert ties.size == 0
    assert np.allclose(np.gradient(series[0], time, axis=1)[:, 1:-1], series[1][:, 1:-1], atol=1e-5)
    assert np.allclose(np.gradient(series[1], time, axis=1)[:, 1:-1], series[2][:, 1:-1], atol=1e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('kind = "lift"\n', "kind"),
        ('kind = "stage"\nfrom_m = [0, 0, 0]\n', "to_m"),
        ('kind = "turntable"\ncentre_m = [0, 0, 0]\nradius_m = 0.1\n', "rate_deg_s or encoder"),
        ('kind = "table"\nfile = "none.csv"\n', "none.csv"),
        ("kind = [\n", "no path file"),
    ],
)
def test_a_wrong_path_file_is_refused_with_its_fault(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(SetupError, match=said):
        read_known(written(tmp_path, text))


def test_a_table_must_go_forward(tmp_path: Path) -> None:
    path = tmp_path / "places.csv"
    path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0\n1,0,0,1\n2,0,0,0\n")
    with pytest.raises(SetupError, match="growing time"):
        read_known(path)
