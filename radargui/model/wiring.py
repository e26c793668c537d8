"""The steps of the wiring check: a guided half minute at the antennas."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

WiringKind: TypeAlias = Literal["quiet", "away", "wave"]


@dataclass(frozen=True, slots=True)
class WiringStep:
    """One step; times in s from the beginning of the check.

    Attributes
    ----------
    kind
        quiet: nothing moves; away: the tracer is moved away; wave: a hand is waved in front of one antenna.
    announce_s
        When the operator is warned.
    start_s, end_s
        What lies between is measured.
    receiver
        Which antenna, counted from 0; None where it is not about one.
    """

    kind: WiringKind
    announce_s: float
    start_s: float
    end_s: float
    receiver: int | None = None

    @property
    def instruction(self) -> str:
        """What the operator does, one sentence."""
        if self.kind == "quiet":
            return "Keep everything still, the tracer hanging at its release."
        if self.kind == "away":
            return "Move the tracer slowly and steadily away from all antennas, 10 cm or more."
        return f"Wave a hand close in front of receiver {(self.receiver or 0) + 1}, and keep away from the others."


def wiring_steps(n_receivers: int) -> tuple[WiringStep, ...]:
    """Return the steps for a number of receivers; half a minute for three."""
    # quiet first: against its noise all motion is judged
    steps = [WiringStep("quiet", 0.0, 2.0, 4.0), WiringStep("away", 4.0, 7.0, 12.0)]
    for receiver in range(n_receivers):
        begin_s = steps[-1].end_s
        # 2.5 s to walk to the next antenna
        steps.append(WiringStep("wave", begin_s, begin_s + 2.5, begin_s + 6.0, receiver))
    return tuple(steps)
