"""What is said of a drop with a broken channel: is the wrong receiver called good, is there a track from it?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.broken.drops import Drop

from radargui.model.result import RunResult

NEAR_M = 0.003
RIGHT_SHARE = 0.9
MIN_RECEIVERS = 3


@dataclass(frozen=True, slots=True)
class DropJudgement:
    """What came out of one drop.

    Attributes
    ----------
    status, reason
        As processed, or in words why there is no result.
    called_good
        Wrong receivers (from 1) called good or usable.
    false_track
        Whether there is a track though fewer than three receivers are right, or one that is off by more than 3 mm.
    right
        Whether what can be known came out: with three right receivers a track within 3 mm in 90 % of the motion,
        else none.
    processor_s
        Processor time.
    """

    status: str
    reason: str
    called_good: tuple[int, ...]
    false_track: bool
    right: bool
    processor_s: float


def judge_drop(drop: Drop, result: RunResult | str, processor_s: float) -> DropJudgement:
    """Return how right a result is."""
    if isinstance(result, str):
        refused = result.startswith("raised")
        trackable = drop.setup.n_receivers - len(drop.wrong) >= MIN_RECEIVERS
        return DropJudgement(result, "", (), False, refused and not trackable, processor_s)
    channels = () if result.corrected is None else result.corrected.channels
    called_good = tuple(
        receiver + 1
        for receiver in sorted(drop.wrong)
        if receiver < len(channels) and channels[receiver].verdict != "rejected"
    )
    tracked, near = _track_shares(drop, result)
    trackable = drop.setup.n_receivers - len(drop.wrong) >= MIN_RECEIVERS
    false_track = tracked > 0.0 and (not trackable or near < RIGHT_SHARE * tracked)
    right = near >= RIGHT_SHARE and result.status == "ok" if trackable else tracked == 0.0
    return DropJudgement(result.status, result.reason, called_good, false_track, right, processor_s)


def _track_shares(drop: Drop, result: RunResult) -> tuple[float, float]:
    """Return the shares of the motion that are called valid, and that are valid and within 3 mm of the truth."""
    if result.track is None:
        return 0.0, 0.0
    first = 0 if result.recording.excerpt is None else result.recording.excerpt.first_stored
    begin, end = drop.moving
    inside = np.arange(result.track.valid.size) + first
    inside = (inside >= begin) & (inside < end)
    valid = result.track.valid & inside
    truth_m = drop.position_m[:, first : first + valid.size]
    near = valid & (np.linalg.norm(result.track.position_m - truth_m, axis=0) <= NEAR_M)
    return float(valid.sum() / (end - begin)), float(near.sum() / (end - begin))
