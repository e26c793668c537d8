"""The unknowns of one receiver's circle, their priors, and when the fit ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True, slots=True)
class CircleSettings:
    """Priors and stops of the fit; amplitudes are those of the scaled samples, about one. Chosen by hand.

    Attributes
    ----------
    offset, log_gain, quadrature_error_rad, log_amplitude
        Deviations of the constants around their prior means, wide enough for any front end of the field.
    bias, log_amplitude_map
        Deviations of the maps' coefficients before they are re-estimated.
    min_deviation, max_deviation
        Limits of the re-estimated deviations; at the lower one a map is switched off.
    updates
        How often the deviations are re-estimated.
    furthest
        Bound of |ln g| and |eps|. It lies far outside of what `correction.quality` accepts, so that an estimate at the
        bound is refused.
    huber_sigmas
        Beyond so many standard deviations a residual counts linearly, not by its square (Huber).
    first_damping, max_damping, damping_factor
        Damping of Gauss-Newton as shares of the diagonal (Marquardt 1963): in the first step, at most, and the factor
        after a step that fails.
    steps, close, worth
        Largest number of steps. The fit ends after a step that changes ln likelihood by less than `close`, and before
        one that can gain only the share `worth` of that.
    min_amplitude
        Least amplitude of a constant ellipse as a start.
    """

    offset: float = 0.3
    log_gain: float = 0.15
    quadrature_error_rad: float = 0.15
    log_amplitude: float = 0.5
    bias: float = 0.2
    log_amplitude_map: float = 0.2
    min_deviation: float = 2e-3
    max_deviation: float = 0.5
    updates: int = 2
    furthest: float = 0.8
    huber_sigmas: float = 3.0
    first_damping: float = 1e-3
    max_damping: float = 1e4
    damping_factor: float = 10.0
    steps: int = 25
    close: float = 0.02
    worth: float = 0.1
    min_amplitude: float = 0.05


CIRCLE = CircleSettings()


@dataclass(frozen=True, slots=True)
class CircleLayout:
    """Places of a circle's unknowns in theta: five constants, then the coefficients of its maps.

    Attributes
    ----------
    n_bias, n_amplitude_map
        Numbers of functions of each bias map and of the map of log amplitude.
    """

    # at the same places whatever the numbers of functions: constants go over from round to round as they are
    offset_i: ClassVar[int] = 0
    offset_q: ClassVar[int] = 1
    log_gain: ClassVar[int] = 2
    quadrature_error: ClassVar[int] = 3
    log_amplitude: ClassVar[int] = 4
    front_end: ClassVar[slice] = slice(2, 4)
    constants: ClassVar[slice] = slice(0, 5)

    n_bias: int
    n_amplitude_map: int

    @property
    def bias_i(self) -> slice:
        """Coefficients of the bias of I."""
        return slice(5, 5 + self.n_bias)

    @property
    def bias_q(self) -> slice:
        """Coefficients of the bias of Q."""
        return slice(5 + self.n_bias, 5 + 2 * self.n_bias)

    @property
    def bias(self) -> slice:
        """Coefficients of both."""
        return slice(5, 5 + 2 * self.n_bias)

    @property
    def amplitude_map(self) -> slice:
        """Coefficients of the map of log amplitude."""
        return slice(5 + 2 * self.n_bias, self.size)

    @property
    def size(self) -> int:
        """Length of theta."""
        return 5 + 2 * self.n_bias + self.n_amplitude_map
