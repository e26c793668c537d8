"""What is shown now: one value that banner, view across the room, title, footer and the line of the series read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from radargui.experiment.event import LIVE
from radargui.files.run_card import origin_of_source
from radargui.gui.control.state import NOT_RECORDED, AppState, RunWord
from radargui.gui.layout import ticking
from radargui.gui.notices import NoticeStrip
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.runs.run_model import RunEntry, live_words, restitution_of
from radargui.gui.services import Services
from radargui.model.rounding import UNKNOWN
from radargui.model.words import counted, percent, sentence
from radargui.sources.factory import SourceKind

NO_RESULT_YET = f"e = {UNKNOWN}"
"""Stands in place of a result until the live track or the first computation tells one: an earlier one would be taken
for its own."""
ENDED_BY_HAND = "the last recording was ended by hand, no run was kept"
_COMPUTING = (AppState.PROCESSING, AppState.STOPPING)


@dataclass(frozen=True, slots=True)
class Situation:
    """What the program does, and what the run gave that is spoken of.

    Attributes
    ----------
    state
        What the program does.
    word, role
        What stands in large letters, and its colour: where nothing runs, what has become of the run.
    doing
        What belongs to the state: which run is recorded or computed, how far; why it failed.
    coming
        The run that is recorded or computed, where that is not the one that the result is of: `drop 3 (3 of 10)`.
    entry
        The run that the result is of; None where there is none.
    result
        e with its combined uncertainty, `no e`, a dash while the present run has none yet, or that nothing is
        recorded; `live e` is what the live track saw, until it is computed; empty: nothing to be said.
    series
        What the drops that count gave together; empty without any.
    next, why
        What the operator does now; what speaks against the result.
    badge
        Where the samples come from that are shown, or will be: SIMULATED, REPLAY, NI Dev1; empty where nobody knows.
    sound
        Which sounds are on.
    """

    state: AppState = AppState.IDLE
    word: str = AppState.IDLE.value
    role: str = AppState.IDLE.role
    doing: str = ""
    coming: str = ""
    entry: RunEntry | None = None
    result: str = ""
    series: str = ""
    next: str = AppState.IDLE.next
    why: str = ""
    badge: str = ""
    sound: str = ""

    @property
    def says(self) -> str:
        """The run with its result, and with what reserve: `drop 3: e = 0.8123 ± 0.0012, 1 warning`."""
        return f"{self.entry.called}: {_joined(self.result, self._reserve)}" if self.entry is not None else self.result

    @property
    def detail(self) -> str:
        """What stands behind the word in the banner."""
        return "   ".join(filter(None, (self.doing, self.says)))

    @property
    def run(self) -> str:
        """Which run the result across the room is of, or which one comes."""
        of = self.entry.called if self.entry is not None else ""
        return "; ".join(filter(None, (self.coming, f"e of {of}" if of and self.coming else of)))

    @property
    def title(self) -> str:
        """What the title of the window says of the run."""
        return f"{self.says} ({self.entry.word.value})" if self.entry is not None else ""

    @property
    def footer(self) -> str:
        """What the foot of the window says of the run: what it gave, and how it was recorded."""
        if self.entry is None:
            return ""
        said = _joined(self.entry.word.value, self.result, self._reserve)
        return ". ".join(filter(None, (f"{self.entry.name}: {said}", self.entry.health)))

    @property
    def _reserve(self) -> str:
        if self.entry is None:
            return ""
        # the large word says it already
        return _joined(*(part for part in self.entry.spoken_reserve.split(", ") if part.upper() != self.word))


def _joined(*parts: str) -> str:
    return ", ".join(filter(None, parts))


class SituationModel(QObject):
    """Makes the situation of what the program does and of the list of runs, whenever one of them changes.

    Parameters
    ----------
    strip
        Where the reason of a failure is said, until it is dismissed there.
    chosen
        Returns the source that Record would use, and its device.

    Attributes
    ----------
    now
        The situation.
    newest
        The run whose result came last; None where none has come yet.
    hardly_seen
        While it is armed, why a fall may not start the run; empty where it would.
    sound
        Which sounds are on.
    """

    changed = Signal()

    def __init__(
        self, runs: RunListPanel, strip: NoticeStrip, chosen: Callable[[], tuple[SourceKind, str]], services: Services
    ) -> None:
        super().__init__(services.parent)
        self.runs, self._strip, self._services, self.control = runs, strip, services, services.control
        self._chosen = chosen
        self.now = Situation()
        self.newest: Path | None = None
        self._failure = self.hardly_seen = self.sound = ""
        # of many runs that are listed one after the other once
        self._soon = ticking(self, 0, self.look, once=True)
        runs.model.altered.connect(self._soon.start)
        runs.table.selectionModel().selectionChanged.connect(lambda *_: self._soon.start())
        control = self.control
        control.state_changed.connect(self.look)
        control.bounced.connect(self.look)
        control.session_changed.connect(self._forget)
        services.board.changed.connect(self.look)

    def take(self, run: Path) -> None:
        """Speak of a run whose result has come, unless a later one has its own already."""
        if not self.runs.model.is_overtaken(run):
            self.newest = run
        self.look()

    def fail(self, reason: str) -> None:
        """Say why the program failed, also where the message was dismissed."""
        self._failure = reason
        self.look()

    def look(self) -> None:
        """Look what has changed; asked as often as the health line."""
        situation = self._present()
        if situation != self.now:
            self.now = situation
            self.changed.emit()

    def _forget(self) -> None:
        self.newest = None
        self.look()

    @property
    def _entry(self) -> RunEntry | None:
        """The run that is spoken of: where nothing runs the one that is chosen, else the newest result."""
        chosen = self.runs.table.all_chosen
        if not self.control.state.running and len(chosen) == 1:
            return self.runs.model.entry_of(chosen[0].path)
        return self.runs.model.entry_of(self.newest)

    @property
    def coming(self) -> str:
        """What the run is called that is armed or recorded: `drop 3 (3 of 10)`."""
        control, labels = self.control, [one.label for one in self.runs.model.entries]
        n_replays, n_drops = sum(one.startswith("R") for one in labels), sum(map(str.isdecimal, labels))
        coming = f"replay {n_replays + 1}" if control.kind == "replay" else f"drop {n_drops + 1}"
        return coming + (f" ({control.run_number} of {control.n_runs})" if control.n_runs > 1 else "")

    def _present(self) -> Situation:
        state, entry = self.control.state, self._entry
        series = self.runs.model.series
        said = f"e = {series.words}" if series.e.n else series.words and f"no e yet, {series.words}"
        bare = Situation(
            state,
            state.value,
            state.role,
            self._doing,
            series=said,
            next=self._next,
            why=self._why(entry),
            badge=self._badge(entry),
            sound=self.sound,
        )
        if state is AppState.LIVE:
            return replace(bare, result=NOT_RECORDED)
        if state in (AppState.STARTING, AppState.FAILED):
            return bare
        if state in _COMPUTING:
            backlog = self.control.backlog
            at_hand = backlog.computed or backlog.last_recorded
            if at_hand is None and state is AppState.STOPPING:
                return bare
            # what is on the disk comes into the list a moment later
            computed = self.runs.model.entry_of(at_hand)
            if computed is None or computed.word is RunWord.NOT_COMPUTED:
                result = computed.result if computed is not None and computed.live else self._seen_live
                return replace(bare, coming=computed.called if computed else self.coming, result=result)
            # also where a later one has its preliminary result already
            entry = computed
        elif state in (AppState.RECORDING, AppState.SETTLING):
            return replace(bare, coming=self.coming, result=self._seen_live)
        if state is AppState.ARMED:
            bare = replace(bare, coming=self.coming)
            last = self.runs.model.entry_of(self.control.backlog.last_recorded)
            # the drop that was just seen, not the one before it whose result came last
            entry = last if last is not None and last.live else entry
        if entry is None:
            return bare
        is_known = bool(entry.live) or entry.word is not RunWord.NOT_COMPUTED
        bare = replace(bare, entry=entry, result=entry.result if is_known else NO_RESULT_YET)
        return bare if state.running else replace(bare, word=entry.word.value, role=entry.role)

    @property
    def _seen_live(self) -> str:
        """What the live track has seen of the run under way, or its flights tell so far."""
        bounce = self.control.live_bounce
        if bounce is None:
            return NO_RESULT_YET
        e = restitution_of(bounce)
        return live_words(e) if bounce.method == LIVE else f"e = {e}, preliminary"

    def _badge(self, entry: RunEntry | None) -> str:
        """Say where it comes from: while something runs of that, else of the run, the session, or what is chosen."""
        control, origin = self.control, self.control.reached.origin
        if control.state.running and origin is not None:
            return origin.badge
        if not control.state.running and entry is not None and entry.origin is not None:
            return entry.origin.badge
        if not control.state.running and control.session is not None:
            own = {one.origin.badge for one in self.runs.model.entries if one.origin is not None}
            return own.pop() if len(own) == 1 else control.session.info.source
        kind, device = self._chosen()
        return origin_of_source(kind, None, device).badge

    @property
    def _doing(self) -> str:
        control = self.control
        match control.state:
            case AppState.IDLE:
                return ENDED_BY_HAND if control.ended_by_hand else ""
            case AppState.ARMED:
                doing = f"{self.coming}, waiting for {control.waits_for or 'motion'}"
                doing += " that may not be seen: see the message below" if self.hardly_seen else ""
                last = self.runs.model.entry_of(control.backlog.last_recorded)
                recorded = f"{last.called} recorded;" if last is not None and last.path != self.newest else ""
                return "   ".join(filter(None, (doing, recorded)))
            case AppState.RECORDING:
                return f"{self.coming}, {control.recorded_s:.1f} s"
            case AppState.SETTLING:
                return f"{self.coming}, waiting until nothing moves"
            case AppState.PROCESSING:
                entry = self.runs.model.entry_of(control.backlog.computed)
                waiting = f", {len(control.backlog) - 1} more wait" if len(control.backlog) > 1 else ""
                return f"{entry.called} {self._computed}{waiting}" if entry is not None else ""
            case AppState.FAILED:
                # where the reason was dismissed it stands here
                return "see the message below" if self._failure in self._strip.texts() else self._failure
            case AppState.DONE:
                n_drops = self.runs.model.series.e.n
                return counted(n_drops, "drop") if control.n_runs > 1 and n_drops > 1 else ""
        return ""

    @property
    def _computed(self) -> str:
        """How much of the run is computed; empty where none is any more: its last step would seem to begin anew."""
        return percent(self.control.progress) if self.control.backlog else ""

    @property
    def _next(self) -> str:
        state, control, notices = self.control.state, self.control, self._services.board.notices
        if state is AppState.FAILED and notices:
            return notices[0].text
        if state is AppState.ARMED and control.waits_for:
            return f"Waiting for {control.waits_for}"
        if state is AppState.ARMED and self.hardly_seen:
            return self.hardly_seen
        if state is AppState.PROCESSING:
            return ": ".join(filter(None, (state.next, self._computed)))
        return state.next

    def _why(self, entry: RunEntry | None) -> str:
        if self.control.state is AppState.IDLE and self.control.ended_by_hand:
            return sentence(ENDED_BY_HAND)
        if self.control.state.running or entry is None:
            return ""
        why = entry.spoken_reserve
        if entry.has_e and entry.warnings:
            # that there is one helps nobody who stands too far away to look for it
            why = why.replace(counted(len(entry.warnings), "warning"), entry.warnings[0])
        return sentence(why) if why else ""
