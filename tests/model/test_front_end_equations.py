"""The front end's equations against each other and against finite differences."""

from __future__ import annotations

import numpy as np
from hypothesis import given, strategies as st

from radargui.model.front_end import channels_of, point_of

angles = st.floats(-1.2, 1.2)
gains = st.floats(0.3, 3.0)


@given(gains, angles)
def test_the_point_of_the_channels_of_a_signal_is_the_signal(gain: float, eps: float) -> None:
    z = np.exp(1j * np.linspace(0.0, 7.0, 50)) * np.linspace(0.5, 2.0, 50)
    x, y = point_of(*channels_of(z, z, gain, eps), gain, eps)
    np.testing.assert_allclose(x + 1j * y, z, atol=1e-12)


def test_q_lags_by_the_quadrature_error_and_is_larger_by_the_gain() -> None:
    phase = np.linspace(0.0, 6.0, 30)
    i, q = channels_of(np.exp(1j * phase), np.exp(1j * phase), 1.3, 0.2)
    np.testing.assert_allclose(i, np.cos(phase))
    np.testing.assert_allclose(q, 1.3 * np.sin(phase + 0.2))
