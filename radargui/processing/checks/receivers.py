"""What is wrong with samples, receivers and clock: what was lost, what is no receiver and what a run does without."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from radargui.model.channel_quality import unexplained_of
from radargui.model.finding import Finding, warn
from radargui.model.recording import Recording
from radargui.processing.checks.evidence import Evidence


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


def rejected(evidence: Evidence) -> Iterator[Finding]:
    """Receivers that the track needs are none, or were rejected."""
    faults, without = evidence.part.faults, evidence.part.goes_on_without
    found = [(k, one.finding) for k, one in enumerate(evidence.channels) if one.verdict == "rejected"]
    # what is no receiver first: without it, its neighbours are hard to judge
    for k, finding in sorted(found, key=lambda one: faults[one[0]] is None):
        if finding is not None and not (without and faults[k]):
            yield replace(finding, receiver=k + 1)


def dips_left_out(evidence: Evidence) -> Iterator[Finding]:
    """Yield where milliseconds of a receiver were left out, which no motion of the sphere explains."""
    for number, why in unexplained_of(evidence.part.left_out).items():
        yield Finding("dip_left_out", "warn", number + 1, {"cause": why})


def clock_wrong(evidence: Evidence) -> Finding | None:
    """All phases turn as in a fall that is several times too fast or too slow."""
    return evidence.part.whole.clock


def left_out(evidence: Evidence) -> Iterator[Finding]:
    """The run goes on without receivers."""
    for k, fault in enumerate(evidence.part.faults, 1):
        if fault is not None and evidence.part.goes_on_without:
            yield Finding("receiver_left_out", "warn", k, {"cause": fault})


def usable(evidence: Evidence) -> Iterator[Finding]:
    """Receivers are usable, and no more."""
    for k, channel in enumerate(evidence.channels, 1):
        if channel.finding is not None and channel.verdict == "usable":
            yield replace(channel.finding, receiver=k)
