"""A drop as a series needs it: the origin of its samples, and the few figures that it gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Literal

from radargui.model.rounding import quantity

RunKind = Literal["measured", "simulated", "replay", "unknown"]


@dataclass(frozen=True, slots=True)
class RunOrigin:
    """Where the samples of a run come from.

    Attributes
    ----------
    kind
        Measured by a device (here or elsewhere), simulated, or played again from a file; unknown where the run file
        cannot be read.
    samples
        Checksums of the channels and their length; empty where unknown. Equal checksums mean equal samples.
    file, first_sample
        For a replay, the file and the sample at which the run begins; empty and None for others.
    of_simulated
        For a replay, whether the replayed run was simulated.
    source
        For a measurement, the name of its source for people (`NI Dev1`, a plug-in); empty where unknown.
    """

    kind: RunKind = "measured"
    samples: str = ""
    file: str = ""
    first_sample: int | None = None
    of_simulated: bool = False
    source: str = ""

    @property
    def mark(self) -> str:
        """The mark of a run that is no measurement (simulated, replayed); empty for a measurement."""
        if self.kind == "replay" and self.of_simulated:
            return "replay of simulated"
        return "" if self.kind in ("measured", "unknown") else self.kind

    @property
    def badge(self) -> str:
        """The badge beside all that is shown of a run: SIMULATED, NI Dev1; empty where its origin is unknown."""
        return self.mark.upper() or self.source

    def is_same_drop(self, other: RunOrigin) -> bool:
        """Return whether both hold the same samples, or the same place of the same file."""
        # of a replay that ended elsewhere the checksums differ: the place tells
        place = (self.file, self.first_sample)
        same_place = self.file != "" and self.first_sample is not None and place == (other.file, other.first_sample)
        return same_place or (self.samples != "" and self.samples == other.samples)


@dataclass(frozen=True, slots=True)
class Drop:
    """One run of a series.

    Attributes
    ----------
    name
        Stem of the run file.
    origin
        Where its samples come from.
    e, u_e, u_e_combined, g_m_s2, u_g_m_s2, u_g_combined_m_s2, drop_height_m, impact_speed_m_s
        Values of the first bounce and the first fall; None where unknown or not valid.
    from_rest
        Whether the rest before the fall was recorded; only then the first bounce found is the first one.
    preliminary
        Whether the wanted correction is still being computed; the present values have less reliable uncertainties.
    """

    name: str
    origin: RunOrigin = field(default_factory=RunOrigin)
    e: float | None = None
    u_e: float | None = None
    u_e_combined: float | None = None
    g_m_s2: float | None = None
    u_g_m_s2: float | None = None
    u_g_combined_m_s2: float | None = None
    drop_height_m: float | None = None
    impact_speed_m_s: float | None = None
    from_rest: bool = True
    preliminary: bool = False


_FIGURES = [one.name for one in fields(Drop) if one.default is None]


def drop_of(name: str, origin: RunOrigin, summary: Mapping[str, object] | None) -> Drop:
    """Return a drop from the summary of its result, see `files.run_card.summarise`; None: it was not processed."""
    return Drop(
        name,
        origin,
        # 0.1 did not keep it
        from_rest=(summary or {}).get("from_rest") is not False,
        preliminary=bool((summary or {}).get("preliminary")),
        **{key: figure_in(summary, key) for key in _FIGURES},
    )


def figure_in(summary: Mapping[str, object] | None, key: str) -> float | None:
    """Return a figure of a run's summary; None where it is not known."""
    value = (summary or {}).get(key)
    return value if isinstance(value, float) else None


def restitution_words(summary: Mapping[str, object] | None, *, statistical: bool = False) -> str:
    """Return "0.8123 ± 0.0012" for the first bounce of a summary: ± combined where it is known, else statistical.

    Parameters
    ----------
    summary
        See `files.run_card.summarise`.
    statistical
        Whether the statistical part is asked for in any case: what differs between runs on one setup.
    """
    return _words(summary, "e", "u_e", "" if statistical else "u_e_combined", "")


def gravity_words(summary: Mapping[str, object] | None, unit: str = "", *, statistical: bool = False) -> str:
    """Return the same for g of the first fall."""
    return _words(summary, "g_m_s2", "u_g_m_s2", "" if statistical else "u_g_combined_m_s2", unit)


def _words(summary: Mapping[str, object] | None, key: str, u: str, u_combined: str, unit: str) -> str:
    value, own, combined = (figure_in(summary, one) for one in (key, u, u_combined))
    return quantity(value, own if combined is None else combined, unit)
