"""What is said of flights that bend: how much, and by what likely, where nothing else names a cause."""

from collections.abc import Iterable

CONTRADICTED = "flights and g contradict the setup"
"""How a sentence begins that names a place of the setup (`setup_outlier`)."""
NAMED = f"{CONTRADICTED}: likely"
"""The same where that place explains it."""
COUNTED = "; the uncertainties count it as so far off"
"""And how it ends."""
_GUESS = " likely a reflector that is not in the model, or a setup that is wrong by more than it says;"
_REMEDY = ": cover what reflects within a metre, measure the antennas' places again"
_UNSTEADY = (
    " likely a reflector that is not in the model, a setup that is wrong by more than it says, or something that "
    "changed during the motion (oscillator, supply, bystander);"
)
_AGAIN = ": cover what reflects within a metre, record it again"
_OF_SETUP, _MEASURE = " likely a setup that is wrong by more than it says;", ": measure release and antennas again"


def bent_flights(chi_square: float, expected: int, widening: float, *, by_setup: bool = False) -> str:
    """Return the sentence, with a guess at the cause.

    Parameters
    ----------
    chi_square, expected
        Of the free motion against its flights, and its degrees of freedom.
    widening
        What the uncertainties were multiplied by.
    by_setup
        Whether values of the setup that are off by some u explain it all.
    """
    guess, remedy = (_OF_SETUP, _MEASURE) if by_setup else (_GUESS, _REMEDY)
    return (
        "the flights bend by more than what is known can make them "
        f"(chi-square {chi_square:.0f} of {expected}):{guess} the uncertainties of track, e and g were widened "
        f"{widening:.1f} times{remedy}"
    )


def unsteady(chi_square: float, expected: int, widening: float) -> str:
    """Return the sentence where flights do not fit, but keep to the motion within what it is known to; as above."""
    return (
        f"the flights fit worse than noise and setup make them (chi-square {chi_square:.0f} of {expected}), though "
        f"they keep within what the position is known to:{_UNSTEADY} the uncertainties of track, e and g were widened "
        f"{widening:.1f} times{_AGAIN}"
    )


def without_guess(warnings: Iterable[str]) -> list[str]:
    """Return sentences without guesses: for where another one names the cause."""
    out = []
    for one in warnings:
        for guess in (_GUESS, _REMEDY, _OF_SETUP, _MEASURE, _UNSTEADY, _AGAIN):
            one = one.replace(guess, "")
        out.append(one)
    return out


def without_places(warnings: Iterable[str]) -> list[str]:
    """Return sentences without those that name a place: a setup that no laboratory has lets flights name any."""
    return [one for one in warnings if not one.startswith(CONTRADICTED)]
