"""The track: where the centre of the sphere was."""

from dataclasses import dataclass

from radargui.model.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class Track:
    """Position against time.

    Attributes
    ----------
    time_s
        Shape (n_samples,).
    position_m
        Centre of the sphere, shape (3, n_samples); NaN where unknown.
    u_position_m
        Standard uncertainty, shape (3, n_samples).
    valid
        Shape (n_samples,).
    geometry
        exact or plane.
    u_combined_m
        Standard uncertainty with what antennas, release and sphere leave open, shape (3, n_samples); None where it was
        not carried.
    """

    time_s: FloatArray
    position_m: FloatArray
    u_position_m: FloatArray
    valid: BoolArray
    geometry: str
    u_combined_m: FloatArray | None = None
