"""What is said of flights that bend: how much, and by what likely, where nothing else names a cause."""

from collections.abc import Iterable

_GUESS = " likely a reflector that is not in the model, or a setup that is wrong by more than it says;"
_REMEDY = ": cover what reflects within a metre, measure the antennas' places again"
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
        "they keep within what the position is known to: likely something changed during the motion, as an oscillator, "
        "a supply or a bystander does; the uncertainties of track, e and g were widened "
        f"{widening:.1f} times: record it again"
    )


def without_guess(warnings: Iterable[str]) -> list[str]:
    """Return sentences without that guess: for where another one names the cause."""
    out = []
    for one in warnings:
        for guess in (_GUESS, _REMEDY, _OF_SETUP, _MEASURE):
            one = one.replace(guess, "")
        out.append(one)
    return out
