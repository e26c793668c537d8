"""What the channels of a drop are linear in, beside waves that the motion turns (method 4, Flights first)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray

ASIDE = 2
"""x and y: an R that changes with the angle does so aside as well as up and down."""


@dataclass(frozen=True, slots=True)
class LinearPart:
    """What a receiver's channels are linear in, and its prior; amplitudes are about one.

    Attributes
    ----------
    free_ways
        Whether each way over the floor and its mirror image in the IQ plane has an amplitude of its own: a start that
        knows neither floor nor front end. Else the forward model's own product of T and R, and gain and quadrature.
    n_functions
        Functions of the height fallen, Legendre polynomials from the first on, for amplitude and offsets.
    u_amplitude, u_way, u_image, u_offset, u_harmonic
        Prior deviations: of the direct wave; in a start of what comes over the floor and of images; of offsets; of what
        a mixer makes of the echo that turns at -3 and +3 times its phase.
    u_lobe
        The same of the first `n_lobe` functions of amplitude and phase: antennas that do not point to the centre.
    n_lobe
        How many those are.
    u_scattered
        Where deviations begin that are re-estimated for each receiver (`DropModel.scattered`): those of the other
        functions and of the offsets', what else reflects, a wall of some per cent; and that of an uneven floor's.
    n_uneven
        Functions of the height for each way over the floor: a small plate, or one whose R changes with the angle.
    n_aside
        `ASIDE` where these ways change with x and y too, else 0.
    n_slow
        Functions of time of each channel, which carry the drift that its rest shows.
    """

    free_ways: bool
    n_functions: int
    u_amplitude: float = 3.0
    u_way: float = 0.5
    u_image: float = 0.2
    u_offset: float = 3.0
    u_harmonic: float = 1e-3
    u_lobe: float = 0.1
    n_lobe: int = 2
    u_scattered: float = 0.03
    n_uneven: int = 0
    n_aside: int = 0
    n_slow: int = 0

    @property
    def n_waves(self) -> int:
        """How many columns waves of constant amplitude have."""
        return 16 if self.free_ways else 2

    @property
    def n_harmonics(self) -> int:
        """How many columns harmonics have; a start has none."""
        return 0 if self.free_ways else 4

    @property
    def n_floor(self) -> int:
        """How many functions of the place each way over the floor has."""
        return self.n_uneven + self.n_aside

    @property
    def group(self) -> IntArray:
        """Of each column which deviation holds: 0 its own, 1 that of what else reflects, 2 of an uneven floor."""
        waves, changes = np.zeros(self.n_waves), np.repeat(np.arange(self.n_functions) >= self.n_lobe, 2)
        offsets = np.repeat([0, 1], [2, 2 * self.n_functions])
        floor = np.full(6 * self.n_floor, 2)
        rest = np.zeros(self.n_harmonics), floor, np.zeros(2 * self.n_slow)
        return np.concatenate([waves, changes, offsets, *rest]).astype(np.intp)

    @property
    def offsets(self) -> slice:
        """Where the offsets of I and Q stand by turns, each a function of the height."""
        first = self.n_waves + 2 * self.n_functions
        return slice(first, first + 2 + 2 * self.n_functions)

    @property
    def uneven(self) -> slice:
        """Where the functions of the ways over the floor stand: those by T, by R and by both, real and imaginary."""
        first = self.offsets.stop + self.n_harmonics
        return slice(first, first + 6 * self.n_floor)

    @property
    def slow(self) -> slice:
        """Where the functions of time stand, those of I before those of Q."""
        return slice(self.uneven.stop, self.uneven.stop + 2 * self.n_slow)

    def deviations(self, scattered: FloatArray) -> FloatArray:
        """Return the prior deviations of the columns, (n_receivers, n_columns), of `scattered`, (n_receivers, 2)."""
        ways = [self.u_amplitude] * 2 + [self.u_way] * 6
        # of exchanged wires the image is all there is
        images = [self.u_amplitude] * 2 + [self.u_image * self.u_way] * 6
        waves = ways + images if self.free_ways else [self.u_amplitude] * 2
        rest = [self.u_lobe] * (2 * self.n_functions) + [self.u_offset] * 2 + [1.0] * (2 * self.n_functions)
        rest += [self.u_harmonic] * self.n_harmonics + [1.0] * (6 * self.n_floor + 2 * self.n_slow)
        shared = np.concatenate([np.ones((len(scattered), 1)), scattered], axis=1)[:, self.group]
        return np.where(self.group > 0, shared, np.array(waves + rest))
