"""What the wiring check says: a sentence for each finding, and the settings that correct it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from radargui.model.setup import Setup

FindingKind: TypeAlias = Literal["good", "dead", "clipped", "same", "swapped", "direction", "unclear"]


@dataclass(frozen=True, slots=True)
class WiringFinding:
    """One finding.

    Attributes
    ----------
    kind
        good: nothing to do; dead: an input without signal; clipped: one at the end of its range; same: I and Q carry
        one signal; swapped: channels at another antenna; direction: a path length that falls; unclear: to be measured
        again.
    sentence
        What was found.
    remedy
        What to do about it; empty where nothing.
    receiver
        Which receiver, counted from 0; None where it is about all.
    """

    kind: FindingKind
    sentence: str
    remedy: str = ""
    receiver: int | None = None

    def __str__(self) -> str:
        """Return sentence and remedy."""
        return f"{self.sentence} {self.remedy}".strip()


@dataclass(frozen=True, slots=True)
class WiringReport:
    """The result of the wiring check.

    Attributes
    ----------
    findings
        One for each receiver that is good, and one for each thing that is not.
    channels
        `daq.channels` as it should be; None where it is right or not known.
    phase_sign
        `radar.phase_sign` as it should be; None where it is right or not known.
    """

    findings: tuple[WiringFinding, ...]
    channels: tuple[str, ...] | None = None
    phase_sign: Literal[-1, 1] | None = None

    @property
    def is_good(self) -> bool:
        """Whether nothing is wrong or unclear."""
        return all(finding.kind == "good" for finding in self.findings)

    @property
    def corrects(self) -> bool:
        """Whether other settings are proposed."""
        return self.channels is not None or self.phase_sign is not None

    def settings(self) -> tuple[str, ...]:
        """Return the proposed settings as lines of a setup file."""
        lines = []
        if self.channels is not None:
            names = ", ".join(f'"{channel}"' for channel in self.channels)
            lines.append(f"daq.channels = [{names}]")
        if self.phase_sign is not None:
            lines.append(f"radar.phase_sign = {self.phase_sign}")
        return tuple(lines)

    def corrected(self, setup: Setup) -> Setup:
        """Return the setup with the proposed settings."""
        if self.channels is not None:
            setup = setup.model_copy(update={"daq": setup.daq.model_copy(update={"channels": self.channels})})
        if self.phase_sign is not None:
            radar = setup.radar.model_copy(update={"phase_sign": self.phase_sign})
            setup = setup.model_copy(update={"radar": radar})
        return setup
