"""What stands beside the word of the state."""

from __future__ import annotations

from radargui.gui.control.app_state import AppState
from radargui.gui.control.run_control import RunControl


def detail_of(control: RunControl, last_run: str) -> str:
    """Return the words that belong to the present state; `last_run` says what the last run gave."""
    of = f"run {control.run_number} of {control.n_runs}, " if control.n_runs > 1 else ""
    known = last_run and (control.kept or control.has_preliminary)
    last = f"   last {last_run}" if known else ""
    match control.state:
        case AppState.DONE:
            return f"{control.kept} runs, the last {last_run}" if control.kept > 1 else last_run
        case AppState.ARMED:
            return f"{of}waiting for {control.waits_for or 'motion'}{last}"
        case AppState.RECORDING:
            return f"{of}{control.recorded_s:.1f} s{last}"
        case AppState.SETTLING:
            return f"{of}waiting until nothing moves{last}"
        case AppState.PROCESSING:
            return f"{of}{100.0 * control.progress:.0f} %{f'   {last_run}' if known else ''}"
        case AppState.FAILED:
            return "see the message above"
        case _:
            return ""
