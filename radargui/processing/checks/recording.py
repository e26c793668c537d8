"""What is wrong with the samples before anything is measured."""

from collections.abc import Iterator

import numpy as np

from radargui.model.finding import Finding, warn
from radargui.model.recording import Recording


def excerpt(recording: Recording) -> Finding | None:
    """Of a long recording only a part is processed."""
    return None if recording.excerpt is None else warn("excerpt_processed", text=recording.excerpt.reason)


def no_numbers(recording: Recording) -> Iterator[Finding]:
    """Samples are no numbers."""
    # converters give nothing else
    if recording.raw.dtype == np.int16:
        return
    for channel, row in zip(recording.digitisation.channel_names, recording.raw, strict=True):
        if missing := int(row.size - np.isfinite(row).sum()):
            which = "all" if missing == row.size else "some"
            yield warn("samples_no_numbers", channel=channel, which=which, missing=missing, samples=row.size)


def samples_lost(recording: Recording) -> Finding | None:
    """Samples were lost while it was recorded."""
    gaps = recording.gaps
    return warn("samples_lost", lost=sum(gap.count for gap in gaps), gaps=len(gaps)) if gaps else None
