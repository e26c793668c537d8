"""A rolling view of samples: decimation that loses no peak, and marks what was lost."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings, strategies as st

from radargui.acquisition.envelope import Envelope, thin


@settings(max_examples=60, deadline=None)
@given(
    sizes=st.lists(st.integers(1, 400), min_size=1, max_size=12),
    window=st.integers(50, 1500),
    bins=st.integers(5, 300),
)
def test_an_envelope_holds_the_extremes_of_its_window_however_samples_come(
    sizes: list[int], window: int, bins: int
) -> None:
    samples = np.random.default_rng(1).standard_normal((2, sum(sizes)))
    envelope = Envelope(2, window, bins)
    first = 0
    for size in sizes:
        envelope.push(first, samples[:, first : first + size])
        first += size
    index, pairs, lost = envelope.view()
    assert envelope.end == samples.shape[1]
    assert not lost.any()
    oldest = int(index[0] - 0.5 * envelope.bin)
    assert oldest <= max(0, samples.shape[1] - window)
    np.testing.assert_array_equal(pairs.max(axis=1), samples[:, oldest:].max(axis=1))
    np.testing.assert_array_equal(pairs.min(axis=1), samples[:, oldest:].min(axis=1))


def test_an_envelope_marks_lost_samples_and_keeps_the_rest() -> None:
    samples = np.ones((2, 1000))
    samples[:, 500:520] = np.nan
    envelope = Envelope(2, 1000, 100)
    envelope.push(0, samples)
    index, pairs, lost = envelope.view()
    assert list(np.flatnonzero(lost)) == [50, 51]
    assert np.isnan(pairs[0, 100:104]).all()
    assert np.isfinite(pairs[0, :100]).all()
    assert index.size == pairs.shape[1] == 2 * lost.size


def test_an_envelope_takes_samples_once_and_jumps_over_what_it_missed() -> None:
    envelope = Envelope(1, 100, 10)
    envelope.push(0, np.full((1, 60), 5.0))
    envelope.push(40, np.concatenate([np.full((1, 20), 99.0), np.full((1, 10), 7.0)], axis=1))
    assert envelope.view()[1].max() == 7.0
    envelope.push(1000, np.zeros((1, 10)))
    assert envelope.view()[1].max() == 0.0


def test_thinning_keeps_the_newest_point() -> None:
    samples = np.arange(1001.0)[None]
    assert thin(samples, 100)[0, -1] == 1000.0
    assert thin(samples, 100).shape[1] <= 100
    assert thin(samples[:, :0], 100).shape == (1, 0)
