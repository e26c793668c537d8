"""The runs of the session as a table: number, time, height of fall, impact speed, e, g, verdict."""

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Any

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication

from radargui.acquisition.run_plan import Ending
from radargui.experiment.event import RecordedRun
from radargui.files.run_card import RunCard, Thumbnail, read_health, summarise
from radargui.gui.control.state import RunWord
from radargui.gui.setup_words import in_words
from radargui.gui.table import RowModel
from radargui.model.drop import Drop, RunOrigin, drop_of, figure_in, gravity_words, restitution_words
from radargui.model.errors import RadarGuiError
from radargui.model.result import Bounce
from radargui.model.rounding import UNKNOWN, plain, quantity
from radargui.model.words import counted, percent, written_time
from radargui.restitution.series import Series, drop_labels, series_of
from radargui.session.session import BY_OPERATOR, was_drop


@dataclass(frozen=True)
class RunEntry:
    """One line of the list.

    Attributes
    ----------
    path
        Run file.
    started_at
        ISO 8601; empty where unknown.
    summary
        What `files.run_card.summarise` gave; None while not processed.
    problem
        Why the file cannot be used; empty where it can.
    rejected
        Why the run does not count; empty where it does. None: as it was known before.
    agreement, health, ending
        How far live was from offline, how the recording went, why it ended (see `Ending`); empty where unknown, or as
        it was known before.
    origin
        Where the samples come from; None where unknown, or as it was known before.
    label
        What the drop is called, see `restitution.series.drop_labels`; the list knows.
    left_out
        Why it is not in the statistics of the series, though nobody set it aside; empty where it is.
    note
        What was noted about it; None: as it was known before.
    waits
        Whether its result is still to come.
    live
        e of its first bounce as the live track saw it, while its result is still to come; empty where unknown.
    thumbnail
        z(t) in small; None where there is none, or as it was known before.
    """

    path: Path
    started_at: str = ""
    summary: Mapping[str, Any] | None = None
    problem: str = ""
    rejected: str | None = None
    agreement: str = ""
    health: str = ""
    ending: str = ""
    origin: RunOrigin | None = None
    label: str = UNKNOWN
    left_out: str = ""
    note: str | None = None
    waits: bool = False
    live: str = ""
    thumbnail: Thumbnail | None = field(default=None, repr=False, compare=False)

    @property
    def name(self) -> str:
        """Name for people: the stem of the file."""
        return self.path.stem

    @property
    def is_drop(self) -> bool:
        """Whether it is numbered as a drop: it counts, or was one before the operator rejected it."""
        return not self.rejected or was_drop(self.rejected)

    @property
    def called(self) -> str:
        """What the banner calls it: `drop 4`, `replay 1`."""
        if self.label == UNKNOWN:
            return self.name
        return f"replay {self.label[1:]}" if self.label.startswith("R") else f"drop {self.label}"

    @property
    def title(self) -> str:
        """What stands above what is shown of it: `drop 4 (run-0007, simulated)`."""
        facts = ", ".join(filter(None, (self.name, self.origin.mark if self.origin else "")))
        return facts if self.label == UNKNOWN else f"{self.called} ({facts})"

    @property
    def drop(self) -> Drop:
        """What a series knows of it."""
        return drop_of(self.name, self.origin or RunOrigin("unknown" if self.problem else "measured"), self.summary)

    @property
    def verdict(self) -> str:
        """How good the run is, in words, and where it comes from: on one line, so that who set it aside is left out."""
        badge = self.origin.badge if self.origin else ""
        if not self.rejected or self.problem:
            return ", ".join(filter(None, (self.quality, badge)))
        reason = self.rejected.removeprefix(BY_OPERATOR).removeprefix(": ")
        return ": ".join(filter(None, (", ".join(filter(None, ("set aside", badge))), reason)))

    @property
    def quality(self) -> str:
        """How good it is, in words."""
        if self.problem:
            return self.problem
        if self.rejected:
            return f"set aside: {self.rejected.removeprefix('rejected ')}"
        if self.summary is None:
            return "recorded, result to come" if self.waits else "not processed"
        says, by_hand = self.summary.get, "ended by hand" if self.ended_by_hand else ""
        if says("status") == "no_motion":
            return ", ".join(filter(None, ("no motion", by_hand)))
        if says("status") == "rejected":
            reason = in_words(str(says("reason") or "no reason given"))
            return ", ".join(filter(None, (f"rejected: {reason}", by_hand)))
        warned = counted(len(self.warnings), "warning") if self.warnings else ""
        made = "preliminary" if says("preliminary") else ""
        return ", ".join(filter(None, (made, says("verdict") or UNKNOWN, warned, by_hand)))

    @property
    def ended_by_hand(self) -> bool:
        """Whether the operator ended its recording before the sphere was at rest."""
        return self.ending == Ending.STOPPED.value

    @property
    def word(self) -> RunWord:
        """What has become of it."""
        summary = self.summary or {}
        if self.rejected or summary.get("status") == "rejected":
            return RunWord.REJECTED
        if self.problem or self.summary is None:
            return RunWord.NOT_COMPUTED
        if summary.get("preliminary"):
            return RunWord.PRELIMINARY
        return RunWord.FINAL if self.has_e else RunWord.NO_E

    @property
    def result(self) -> str:
        """What it gave, as banner, title and footer say it."""
        if self.live:
            return live_words(self.live)
        return f"e = {self.restitution()}" if self.has_e else "no e"

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is to be known before its figures are believed, a sentence each."""
        return tuple(map(in_words, (self.summary or {}).get("warnings") or ()))

    @property
    def reserve(self) -> str:
        """With what reserve its figures are to be read; empty: with none."""
        return ", ".join(part for part in self.quality.split(", ") if part != "good")

    @property
    def objection(self) -> str:
        """What is said first of a run without e: why it was refused, else its first warning."""
        is_measured = not self.rejected and (self.summary or {}).get("status") == "ok"
        return self.warnings[0] if is_measured and self.warnings else self.quality

    @property
    def spoken_reserve(self) -> str:
        """What is said behind its result: with what reserve it is to be read, or why there is none."""
        if self.word is RunWord.NOT_COMPUTED:
            return self.problem
        return self.reserve if self.has_e or self.rejected or self.quality == "good" else self.objection

    @property
    def role(self) -> str:
        """The colour that says how good it is: nothing to object, something to look at, or refused."""
        if self.problem or self.word is RunWord.REJECTED:
            return "alarm"
        return "good" if self.has_e and not self.reserve else "mark"

    @property
    def has_e(self) -> bool:
        """Whether e is known."""
        return (self.summary or {}).get("e") is not None

    def restitution(self) -> str:
        """Return e with its combined uncertainty; what the live track saw says so."""
        return f"{self.live} live" if self.live else restitution_words(self.summary)

    @cached_property
    def cells(self) -> tuple[str, ...]:
        """The texts of the columns; a table asks for them with each line that it makes as high as its words."""
        return tuple(text(self) for text in COLUMNS.values())


# title of a column, and what stands in it; 1000: from m to mm
COLUMNS: dict[str, Callable[[RunEntry], str]] = {
    "Drop": attrgetter("label"),
    "Time": lambda run: written_time(run.started_at, "%H:%M:%S", UNKNOWN),
    "Fall [mm]": lambda run: plain(figure_in(run.summary, "drop_height_m"), scale=1000.0),
    "Impact [m/s]": lambda run: plain(figure_in(run.summary, "impact_speed_m_s")),
    "e": RunEntry.restitution,
    "e of times": lambda run: quantity(figure_in(run.summary, "e_times"), figure_in(run.summary, "u_e_times")),
    "g [m/s²]": lambda run: gravity_words(run.summary),
    "Note": lambda run: run.note or "",
    "Verdict": attrgetter("verdict"),
}
_STATISTICAL = {"e": restitution_words, "g [m/s²]": gravity_words}
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter


class RunModel(RowModel[RunEntry]):
    """The runs of a session, in the order of their numbers.

    Attributes
    ----------
    series
        The statistics of the drops that count.
    """

    altered = Signal()
    """Runs came, went, or are known better."""

    def __init__(self) -> None:
        super().__init__(COLUMNS, lambda entry: f"{entry.name}: {entry.verdict}\n{entry.path}")
        self.series: Series = series_of([])

    def replace_all(self, entries: Iterable[RunEntry]) -> None:
        """Show another session."""
        super().replace_all(sorted(entries, key=_place))
        self._recount()

    def put(self, entry: RunEntry) -> int:
        """Add an entry, or replace the one of the same file; return its row."""
        row = bisect_left(self.entries, _place(entry), key=_place)
        old = self.entry_of(entry.path)
        if old is None:
            self.beginInsertRows(QModelIndex(), row, row)
            self.entries.insert(row, entry)
            self.endInsertRows()
        else:
            names = ("started_at", "agreement", "health", "ending", "origin", "thumbnail")
            known: dict[str, Any] = {name: getattr(entry, name) or getattr(old, name) for name in names}
            known |= {name: getattr(old, name) for name in ("rejected", "note") if getattr(entry, name) is None}
            row = self.entries.index(old)
            self.entries[row] = replace(entry, **known)
        self._recount()
        return row

    def _recount(self) -> None:
        """Number the drops, and tell of each whether it is in the statistics."""
        labels = drop_labels((one.name, one.origin, one.is_drop) for one in self.entries)
        self.series = series_of([entry.drop for entry in self.entries if not entry.rejected])
        left_out = self.series.left_out
        for row, one in enumerate(self.entries):
            numbered = (labels[one.name], left_out.get(one.name, ""))
            if numbered != (one.label, one.left_out):
                self.entries[row] = replace(one, label=numbered[0], left_out=numbered[1])
        if self.entries:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.entries) - 1, len(COLUMNS) - 1))
        self.altered.emit()

    def is_overtaken(self, path: Path) -> bool:
        """Return whether a later run that counts has its result already: quick results do not come in order."""
        later = self.entries[bisect_left(self.entries, _place(RunEntry(path)), key=_place) :]
        return any(one.summary is not None and one.path != path and not one.rejected for one in later)

    def entry_of(self, path: Path | None) -> RunEntry | None:
        """Return the entry of a file; None where there is no such file."""
        return next((entry for entry in self.entries if entry.path == path), None)

    def cell(self, entry: RunEntry, column: int, role: int) -> Any:
        """Return a cell's text, full text, colour or alignment."""
        title, roles = self._titles[column], Qt.ItemDataRole
        if role == roles.DisplayRole:
            return entry.cells[column]
        if role == roles.ToolTipRole and title in _STATISTICAL:
            return f"statistical part of ±: {_STATISTICAL[title](entry.summary, statistical=True)}"
        if role == roles.ToolTipRole and title == "Verdict":
            out = f"not in the statistics: {entry.left_out}" if entry.left_out else ""
            why = entry.quality if entry.rejected else ""
            said = (entry.verdict, why, out, *entry.warnings, entry.agreement, entry.health)
            return "\n".join(filter(None, said)).replace("<", "‹")
        if role == roles.ToolTipRole and title == "Note":
            return (entry.note or "").replace("<", "‹")
        if role == roles.ForegroundRole and (entry.rejected or entry.left_out):
            return QApplication.palette().brush(QPalette.ColorGroup.Disabled, QPalette.ColorRole.Text)
        return _LEFT if role == roles.TextAlignmentRole else super().cell(entry, column, role)


def _place(entry: RunEntry) -> tuple[int, str]:
    """Return what runs are put in order by: the number in the name, whatever its length."""
    return len(entry.name), entry.name


def entry_of_recorded(recorded: RecordedRun, path: Path, card: RunCard | None = None) -> RunEntry:
    """Return what the list shows of a run just recorded; with its `card` while its result is still to come."""
    result, agreement = recorded.result, recorded.agreement
    return RunEntry(
        path,
        started_at=card.started_at if card else result.recording.started_at if result else "",
        summary=summarise(result) if result else None,
        rejected=recorded.set_aside or None,
        agreement=agreement_words(agreement.record()) if agreement else "",
        health=recorded.health_line,
        ending=str(recorded.health.get("ending", "")),
        origin=card.origin if card else None,
        waits=(waits := card is not None and not recorded.set_aside),
        live=restitution_of(recorded.live) if waits and recorded.live else "",
    )


def restitution_of(bounce: Bounce) -> str:
    """Return "0.8123 ± 0.0012" of a bounce."""
    return quantity(bounce.e, bounce.u_stated)


def live_words(restitution: str) -> str:
    """Return what banner, title and footer say of e that the live track saw."""
    return f"live e = {restitution}"


def with_record(entry: RunEntry) -> RunEntry:
    """Return an entry with what its file says of the recording: live against offline, health, ending."""
    with suppress(RadarGuiError):
        health = read_health(entry.path) or {}
        line, ending = (str(health.get(key, "")) for key in ("line", "ending"))
        return replace(entry, agreement=agreement_words(health), health=line, ending=ending)
    return entry


def agreement_words(health: Mapping[str, object]) -> str:
    """Return how far the live track was from the result; empty where nobody compared."""
    rms, most, known = (health.get(f"live_{key}") for key in ("rms_m", "max_m", "share_known"))
    if not isinstance(rms, float) or not isinstance(most, float):
        return ""
    share = f", known for {percent(known)} of the motion" if isinstance(known, float) else ""
    return f"live within {1e3 * rms:.2f} mm rms of offline, {1e3 * most:.2f} mm at most{share}"
