"""The static ellipse returns the constants it was made of."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from radargui.correction.correct import arc_over_roundness, correct_ellipse
from radargui.model.errors import ProcessingError
from radargui.model.result import Segment
from radargui.signals.ellipse import fit_ellipse


@settings(max_examples=60, deadline=None)
@given(
    gain=st.floats(0.7, 1.4),
    eps=st.floats(-0.3, 0.3),
    i0=st.floats(-3, 3),
    q0=st.floats(-3, 3),
    amplitude=st.floats(0.001, 4.0),
    arc=st.floats(4.0, 40.0),
)
def test_the_ellipse_gives_back_offset_gain_and_quadrature(
    gain: float, eps: float, i0: float, q0: float, amplitude: float, arc: float
) -> None:
    phase = np.linspace(0.3, 0.3 + arc, 2000)
    pair = np.stack([i0 + amplitude * np.cos(phase), q0 + gain * amplitude * np.sin(phase + eps)])
    iq, ellipse = correct_ellipse(pair, Segment(0, 2000, 0, 0))
    assert ellipse.gain_ratio == pytest.approx(gain, rel=1e-4)
    assert ellipse.quadrature_error_rad == pytest.approx(eps, abs=1e-4)
    assert ellipse.amplitude_v == pytest.approx(amplitude, rel=1e-4)
    assert iq == pytest.approx(np.stack([np.cos(phase), np.sin(phase)]), abs=1e-3)


@pytest.mark.parametrize("pair", [np.zeros((2, 500)), np.stack([np.linspace(0, 1, 500), np.linspace(0, 2, 500)])])
def test_samples_on_no_ellipse_are_refused(pair: np.ndarray) -> None:
    with pytest.raises(ProcessingError, match="no ellipse"):
        correct_ellipse(pair, Segment(0, 500, 0, 0))


def test_a_short_arc_is_refused() -> None:
    phase = np.linspace(0, 1.0, 500)
    with pytest.raises(ProcessingError, match="lie on no ellipse"):
        correct_ellipse(np.stack([np.cos(phase), np.sin(phase)]), Segment(0, 500, 0, 0))


def test_the_conic_under_noise_is_true_within_a_percent() -> None:
    phase = np.linspace(0, 60, 6000)
    pair = np.stack([np.cos(phase), 1.1 * np.sin(phase + 0.1)])
    pair += np.random.default_rng(0).normal(0, 0.03, pair.shape)
    ellipse = fit_ellipse(pair)
    assert ellipse.gain_ratio == pytest.approx(1.1, rel=0.01)
    assert ellipse.quadrature_error_rad == pytest.approx(0.1, abs=0.01)


def test_an_arc_of_which_the_strength_changes_is_round_and_off_and_counts_as_more_uncertain() -> None:
    def worst(turns: float) -> tuple[float, float]:
        """Phase error since the begin over |z| off its circle, and what is expected of that."""
        phase = 2.0 * np.pi * turns * np.linspace(0.0, 1.0, 4000)
        echo = (1.0 + 0.15 * np.linspace(0.0, 1.0, phase.size)) * np.exp(1j * phase)
        iq, _ = correct_ellipse(np.stack([echo.real, echo.imag]), Segment(0, phase.size, 0, 0))
        found = np.unwrap(np.arctan2(iq[1], iq[0]))
        error = np.abs((found - found[0]) - (phase - phase[0])).max()
        return float(error / np.sqrt(np.mean((np.hypot(*iq) - 1.0) ** 2))), arc_over_roundness(found)

    (of_arc, expected), (of_turns, beside) = worst(0.8), worst(5.0)
    assert of_arc > 3.0 * of_turns
    assert expected > 3.0 * beside
    assert beside == pytest.approx(1.0, abs=0.03)
    assert arc_over_roundness(np.full(3, np.nan)) == 1.0
