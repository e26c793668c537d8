"""What stands beside the state in large letters: of which run, how far, and what is known of the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject

from radargui.gui.control.app_state import AppState
from radargui.gui.control.run_control import RunControl
from radargui.gui.control.state_view import StateView
from radargui.gui.control.stopping import StoppingStrip
from radargui.gui.notice_strip import NoticeStrip
from radargui.gui.notices import NoticeBoard


@dataclass(frozen=True, slots=True)
class RunWords:
    """What the armed or recorded run is called, what the one that is computed, and what is new of the others."""

    coming: str
    computed: str
    news: str


def detail_of(control: RunControl, words: RunWords, failure: str) -> str:
    """Return what belongs to the present state.

    Parameters
    ----------
    control
        What is being done.
    words
        What the runs are called.
    failure
        Where the reason of a failure is to be read, or the reason itself.
    """
    of = f" ({control.run_number} of {control.n_runs})" if control.n_runs > 1 else ""
    news = f"   {words.news}" if words.news else ""
    match control.state:
        case AppState.DONE:
            return f"{control.kept} drops{news}" if control.kept > 1 else words.news
        case AppState.ARMED:
            return f"{words.coming}{of}, waiting for {control.waits_for or 'motion'}{news}"
        case AppState.RECORDING:
            return f"{words.coming}{of}, {control.recorded_s:.1f} s{news}"
        case AppState.SETTLING:
            return f"{words.coming}{of}, waiting until nothing moves{news}"
        case AppState.PROCESSING:
            waiting = f", {len(control.backlog) - 1} more wait" if len(control.backlog) > 1 else ""
            return f"{words.computed} {100.0 * control.progress:.0f} %{waiting}{news}".strip()
        case AppState.FAILED:
            return failure
        case _:
            return ""


class Banner(QObject):
    """Keeps the state view and the strip of what is waited for up to date.

    Parameters
    ----------
    control
        What is being done.
    view, stopping
        Where it is said.
    board, strip
        Where the reason of a failure is said, until it is dismissed there.
    words
        Returns what the runs are called.
    """

    def __init__(
        self,
        control: RunControl,
        view: StateView,
        stopping: StoppingStrip,
        board: NoticeBoard,
        strip: NoticeStrip,
        words: Callable[[], RunWords],
    ) -> None:
        # the board may outlive the window: what is deleted with the view hears no more of it
        super().__init__(view)
        self._control, self._view, self._stopping = control, view, stopping
        self._board, self._strip, self._words = board, strip, words
        self._failure = ""
        control.failed.connect(self._fail)
        board.changed.connect(self.look)

    def look(self) -> None:
        """Say what is being done now."""
        words = self._words()
        # where the reason was dismissed it stands here
        failure = "see the message below" if self._failure in self._strip.texts() else self._failure
        self._view.show_state(self._control.state, detail_of(self._control, words, failure))
        self._stopping.look(words.computed)

    def _fail(self, error: BaseException) -> None:
        self._board.post_error(error)
        # the newest error stands first
        self._failure = self._board.notices[0].text
        self.look()
