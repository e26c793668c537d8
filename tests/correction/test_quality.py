"""Quality of a corrected signal against figures that follow from how it was made."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.correction.quality import circularity, image_rejection_db

PHASES = {
    "steady": np.linspace(0.0, 2 * np.pi * 60, 20000),
    "ever faster": 2 * np.pi * 60 * np.linspace(0.1, 1.0, 20000) ** 2,
}


@pytest.mark.parametrize("motion", PHASES)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("rejection_db", [15.0, 30.0, 45.0])
def test_an_image_of_known_size_is_found(motion: str, sign: int, rejection_db: float) -> None:
    phase = sign * PHASES[motion]
    z = np.exp(1j * phase) + 10.0 ** (-rejection_db / 20.0) * np.exp(-1j * phase + 0.7j)
    z = z + 0.003 * np.random.default_rng(0).normal(size=(2, phase.size)).T.copy().view(np.complex128)[:, 0]
    found = image_rejection_db(np.stack([z.real, z.imag]), np.unwrap(np.angle(z)))
    assert found == pytest.approx(rejection_db, abs=1.5)


def test_a_short_motion_has_no_image_rejection() -> None:
    phase = np.linspace(0.0, 2 * np.pi * 3, 2000)
    assert image_rejection_db(np.stack([np.cos(phase), np.sin(phase)]), phase) is None


def test_circularity_is_the_spread_of_the_radius_within_a_fringe() -> None:
    phase = np.linspace(0.0, 300.0, 20000)
    radius = 1.0 + 0.1 * np.sin(7 * phase)
    assert circularity(radius * np.stack([np.cos(phase), np.sin(phase)]), phase) == pytest.approx(
        0.1 / np.sqrt(2), rel=0.03
    )


def test_an_echo_that_grows_fivefold_along_the_way_stays_round() -> None:
    phase = np.linspace(0.0, 300.0, 20000)
    assert circularity(np.linspace(0.4, 2.0, 20000) * np.stack([np.cos(phase), np.sin(phase)]), phase) < 0.03


def test_an_offset_is_not_round() -> None:
    turn = np.linspace(0.0, 300.0, 20000)
    z = np.exp(1j * turn) + 0.3
    assert circularity(np.stack([z.real, z.imag]), np.unwrap(np.angle(z))) == pytest.approx(0.3 / np.sqrt(2), rel=0.1)
