"""What is said about how a run was recorded: live against offline, health."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from radargui.experiment.recorded_run import RecordedRun
from radargui.files.run_health import read_health
from radargui.model.errors import RadarGuiError


def notes_of_run(recorded: RecordedRun) -> tuple[str, str]:
    """Return the agreement of live and offline, and the health line, of a run just recorded; empty where unknown."""
    agreement = recorded.agreement
    return ("" if agreement is None else agreement_words(agreement.record())), recorded.health_line


def notes_of_file(path: Path) -> tuple[str, str]:
    """Return the same from the run's file."""
    try:
        health = read_health(path)
    except RadarGuiError:
        return "", ""
    return ("", "") if health is None else (agreement_words(health), str(health.get("line", "")))


def agreement_words(health: Mapping[str, object]) -> str:
    """Return how far the live track was from the result; empty where nobody compared."""
    rms, most, known = (health.get(f"live_{key}") for key in ("rms_m", "max_m", "share_known"))
    if not isinstance(rms, float) or not isinstance(most, float):
        return ""
    share = f", known for {100.0 * known:.0f} % of the motion" if isinstance(known, float) else ""
    return f"live within {1e3 * rms:.2f} mm rms of offline, {1e3 * most:.2f} mm at most{share}"
