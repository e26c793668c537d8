"""What the flights of a run say of its setup."""

from dataclasses import dataclass, field

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.finding import Finding

NOTHING: FloatArray = np.zeros(1)


@dataclass(frozen=True, slots=True)
class FlightTest:
    """A free motion held against its flights, and these against the setup.

    Attributes
    ----------
    bent
        That they bend as neither noise nor the setup makes them, or were not fitted; None where all is well.
    cause
        What likely makes them bend; None where nothing is known.
    widening
        What u is multiplied by.
    bias_deviations
        Deviation that inputs off by their u give to each receiver's bias maps, in amplitudes, shape (n_receivers,).
    """

    bent: Finding | None = None
    cause: Finding | None = None
    widening: float = 1.0
    bias_deviations: FloatArray = field(default_factory=lambda: NOTHING)

    @property
    def is_explained(self) -> bool:
        """Whether the cause explains all of it."""
        return self.cause is not None and bool(self.cause.facts["explains"])
