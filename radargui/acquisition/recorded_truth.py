"""The truth of exactly the samples that a run holds."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

import numpy as np

from radargui.model.block import Gap
from radargui.model.truth import Truth

TruthOf = Callable[[int, int], Truth | None]
"""`Source.truth`: absolute index of the first sample and count, lost samples counted."""

MAXIMUM_SAMPLES = 20_000_000
_logger = logging.getLogger(__name__)


def recorded_truth(truth_of: TruthOf | None, first_index: int, count: int, gaps: Sequence[Gap]) -> Truth | None:
    """Return the truth beside `count` recorded samples; None where the source knows none.

    Parameters
    ----------
    truth_of
        Asks the source.
    first_index
        Absolute index of the run's first sample.
    count
        Samples recorded.
    gaps
        Samples lost, their indices counted from the run's first sample.
    """
    if truth_of is None or count == 0:
        return None
    span = count + sum(gap.count for gap in gaps)
    if span > MAXIMUM_SAMPLES:
        _logger.warning("The run is too long for its truth to be stored")
        return None
    truth = truth_of(first_index, span)
    if truth is None or not gaps:
        return truth
    kept = np.ones(span, dtype=np.bool_)
    for gap in gaps:
        kept[gap.first_index : gap.first_index + gap.count] = False
    return Truth(truth.position_m[:, kept], truth.path_m[:, kept], truth.impact_time_s)
