"""The adaptive circles at every sample and what is made of them: against closed forms of ideal circles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import ANTENNAS, BOUNCE_S, RELEASE_M, START_S, WAVELENGTH_M, positions, small_problem

from radargui.estimation.adaptive.circle_data import averaging_loss
from radargui.estimation.adaptive.circle_fit import CircleFit
from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.estimation.adaptive.found import AdaptiveRounds
from radargui.estimation.adaptive.rough import RoughPhases
from radargui.estimation.adaptive.rounds import Round
from radargui.estimation.adaptive.samples import circles_at_samples
from radargui.estimation.signals import ScaledSignals
from radargui.physics.path_length import path_lengths
from radargui.signals.ellipse import Ellipse

SIGMA, AT_REST = np.array([0.01, 0.02, 0.01, 0.01, 0.03, 0.01]), np.array([0.4, -2.0, 1.1])
ROUND = tuple(Ellipse(0.2 - 0.1 * n, 0.1 * n, 0.8 + 0.1 * n, 1.0, 0.0) for n in range(3))
SKEW = tuple(
    replace(one, gain_ratio=np.exp(0.1 - 0.1 * n), quadrature_error_rad=0.05 * n) for n, one in enumerate(ROUND)
)


def phases_at(time_s: np.ndarray) -> np.ndarray:
    """Return the phases that a fall shows, zero at rest."""
    change = path_lengths(positions(time_s), ANTENNAS) - path_lengths(RELEASE_M[:, None], ANTENNAS)
    return 2.0 * np.pi * change / WAVELENGTH_M


def found_of(
    ellipses: tuple[Ellipse, ...], *, rate_hz: float = 4000.0, delay_s: float = 0.0, off_rad: float = 0.0
) -> AdaptiveRounds:
    """Return rounds on circles that fit exactly, of phases that the bins have seen off by some, and their samples."""
    data = small_problem(delay_s=delay_s, n_bins=900).data
    bins = replace(data.bins, sigma=np.tile(SIGMA[:, None], 900))
    data = replace(data, bins=bins)
    time = np.arange(0.0005, 0.4495, 1.0 / rate_hz)
    phase, value = phases_at(bins.time_s) + off_rad, []
    for n, own in enumerate(ellipses):
        i, q = (phases_at(time + delay)[n] + AT_REST[n] for delay in data.delay_s[2 * n : 2 * n + 2])
        value.append(own.i0_v + own.amplitude_v * np.cos(i))
        value.append(own.q0_v + own.gain_ratio * own.amplitude_v * np.sin(q + own.quadrature_error_rad))
    signals = ScaledSignals(
        time_s=time,
        value=np.array(value),
        valid=np.ones((3, time.size), bool),
        usable=np.ones(time.size, bool),
        unusable_share=np.zeros(3),
        sigma=SIGMA,
        scale_v=np.ones(3),
        delay_s=data.delay_s,
        mixers=(None,) * 3,
        before=None,
        rate_hz=rate_hz,
        rest_end_s=START_S,
        onset_s=START_S,
    )
    fits = tuple(replace(CircleFit.still(own), chi_square=0.5 + n) for n, own in enumerate(ellipses))
    shown = [
        part
        for n, own in enumerate(ellipses)
        for part in (
            own.i0_v + own.amplitude_v * np.cos(phase[n] + AT_REST[n]),
            own.q0_v + own.amplitude_v * np.sin(phase[n] + AT_REST[n]),
        )
    ]
    amplitude = np.array([np.full(900, own.amplitude_v) for own in ellipses])
    last = Round(
        phase_rad=phase,
        rest_phase_rad=AT_REST,
        value=np.array(shown),
        amplitude=amplitude,
        place=positions(bins.time_s),
        fits=fits,
        bias=None,
        amplitude_map=None,
        log_evidence=0.0,
        prior_mean=np.zeros((3, 5)),
    )
    rough = RoughPhases(bins.time_s, phase, np.zeros(900), ellipses, {})
    return AdaptiveRounds(signals, data, rough, last, np.array([0.25]), np.zeros(0))


@pytest.mark.parametrize("delay_s", [0.0, 2e-5])
def test_samples_have_their_own_phase_whatever_the_bins_have_seen(delay_s: float) -> None:
    found = found_of(SKEW, delay_s=delay_s, off_rad=0.02)
    at = circles_at_samples(found, found.signals)
    wanted, smooth = phases_at(found.signals.time_s), np.abs(found.signals.time_s - BOUNCE_S) > 1e-3
    # bins do not tell what a delay over an impact turns
    assert at.phase_rad[:, smooth] == pytest.approx(wanted[:, smooth], abs=3e-3 if delay_s else 1e-9)
    # samples lie on the unit circle; bins show a turning wave smaller by what their mean loses
    loss = averaging_loss(found.last.phase_rad, found.data.bins)
    shrunk = np.array([np.interp(found.signals.time_s, found.data.bins.time_s, row) for row in loss])
    assert (at.i + 1j * at.q)[:, smooth] == pytest.approx((shrunk * np.exp(1j * wanted))[:, smooth], abs=3e-3)


def test_a_sample_that_is_no_number_or_was_not_usable_is_not_valid() -> None:
    found = found_of(ROUND)
    value, valid = found.signals.value.copy(), found.signals.valid.copy()
    value[0, 1000], valid[1, 1200] = np.nan, False
    estimate = estimate_adaptive(replace(found, signals=replace(found.signals, value=value, valid=valid)))
    assert not estimate.valid[0, 1000]
    assert not estimate.valid[1, 1200]
    assert estimate.valid[1:, 1000].all()
