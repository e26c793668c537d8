"""A guess from names and order which channel of a file is I1, Q1, ..."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from radargui.files.csv_layout import is_time_name
from radargui.files.reading import LARGEST, ChannelEntry, ChannelMap
from radargui.files.signals import ChannelInfo
from radargui.model.digitisation import iq_names

Basis = Literal["names", "order", "remembered", "nothing"]

_PARTS = {"i": "I", "inphase": "I", "in-phase": "I", "re": "I", "real": "I"}
_PARTS |= {"q": "Q", "quadrature": "Q", "quad": "Q", "im": "Q", "imag": "Q", "imaginary": "Q"}
_TOKEN = re.compile(r"in-phase|[a-z]+|\d+", re.IGNORECASE)
_LAST_NUMBER = re.compile(r"(\d+)(?=\D*$)")


@dataclass(frozen=True, slots=True)
class ChannelGuess:
    """Which channel is which, for the user to confirm.

    Attributes
    ----------
    channel_map
        None where nothing can be guessed.
    basis
        names: the names say it; order: only their order does, look at it; remembered: as the user chose before.
    left_out
        Channels of the file that are not used.
    """

    channel_map: ChannelMap | None
    basis: Basis
    left_out: tuple[str, ...] = ()


def guess_channel_map(infos: Sequence[ChannelInfo]) -> ChannelGuess:
    """Return the likely channel map of a file: from names that tell I, Q and a number, else from the order.

    Names such as I1, i_1, ch2_Q, rx0/I, I and Q tell it. Otherwise channels are taken in pairs in the order of the
    number at the end of their names (Voltage, Voltage_0, Voltage_1, ...; ai0, ai1, ...), which only the user can
    confirm. Times and channels of another length than most are left out.

    Parameters
    ----------
    infos
        What `list_channels` gives.
    """
    names = [info.name for info in _alike(infos)]
    every = [info.name for info in infos]
    by_name = _from_names(names)
    if by_name:
        return _guess(by_name, "names", every)
    ordered = sorted(names, key=_number_at_end) if _differ_in_number(names) else names
    usable = min(len(ordered) // 2, LARGEST) * 2
    return _guess(ordered[:usable], "order", every) if usable else ChannelGuess(None, "nothing", tuple(every))


def guess_of_variables(variables: Sequence[str], infos: Sequence[ChannelInfo], basis: Basis) -> ChannelGuess:
    """Return the map that takes `variables` as I1, Q1, ... in this order."""
    return _guess(list(variables), basis, [info.name for info in infos])


def pattern_of(infos: Sequence[ChannelInfo]) -> tuple[str, ...]:
    """Return what files of one kind have in common: their names, without groups and structures where that is enough."""
    names = [info.name for info in infos]
    short = [re.split(r"[/.]", name)[-1] for name in names]
    return tuple(short if len(set(short)) == len(short) else names)


def _guess(variables: Sequence[str], basis: Basis, every: Sequence[str]) -> ChannelGuess:
    targets = iq_names(len(variables) // 2)
    entries = tuple(ChannelEntry(target, name) for target, name in zip(targets, variables, strict=True))
    return ChannelGuess(ChannelMap(entries), basis, tuple(name for name in every if name not in variables))


def _alike(infos: Sequence[ChannelInfo]) -> list[ChannelInfo]:
    samples = [info for info in infos if info.count > 0 and not is_time_name(info.name.strip().rpartition(".")[2])]
    if not samples:
        return []
    lengths = Counter(info.count for info in samples)
    most = max(lengths, key=lambda length: (lengths[length], length))
    return [info for info in samples if info.count == most]


def _from_names(names: Sequence[str]) -> list[str]:
    """Return names as I1, Q1, I2, ...; empty where they do not tell it without doubt."""
    found: dict[tuple[int, str], str] = {}
    for name in names:
        place = _receiver_and_part(name)
        if place is None:
            continue
        if place in found:
            return []
        found[place] = name
    numbers = sorted({number for number, _ in found})
    if not numbers or len(numbers) > LARGEST:
        return []
    wanted = [(number, part) for number in numbers for part in "IQ"]
    return [found[one] for one in wanted] if all(one in found for one in wanted) else []


def _receiver_and_part(name: str) -> tuple[int, str] | None:
    """Return the number (0 where there is none) and I or Q that a name tells; None where it does not."""
    tokens = [token.lower() for token in _TOKEN.findall(name)]
    parts = [_PARTS[token] for token in tokens if token in _PARTS]
    numbers = [int(token[-15:]) for token in tokens if token.isascii() and token.isdigit()]
    if len(parts) != 1:
        return None
    return (numbers[-1] if numbers else 0, parts[0])


def _differ_in_number(names: Sequence[str]) -> bool:
    """Return whether names are the same but for the number at their end, which one of them may lack."""
    stems = {re.sub(r"[_ ]+$", "", _LAST_NUMBER.sub("", name)) for name in names}
    return len(stems) == 1


def _number_at_end(name: str) -> int:
    match = _LAST_NUMBER.search(name)
    return int(match[1][-15:]) if match else -1
