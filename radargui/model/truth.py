"""What really happened in a simulated run; no processing ever reads it."""

from dataclasses import dataclass

from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Truth:
    """Exact motion of the simulated tracer at the times of channel 0.

    Attributes
    ----------
    position_m
        Shape (3, n_samples).
    path_m
        Shape (n_receivers, n_samples).
    impact_time_s
        Shape (n_impacts,), from the first sample.
    """

    position_m: FloatArray
    path_m: FloatArray
    impact_time_s: FloatArray
