"""The health line at the bottom: rate, losses, queues, disk, lag; what is bad stands out in words and colour."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QWidget

from radargui.acquisition.health import Health
from radargui.acquisition.run_plan import AcquisitionState
from radargui.gui.layout import fill
from radargui.gui.theme import Theme
from radargui.model.rounding import UNKNOWN

_LAG_ALARM_S = 0.5
"""From here on a hand sees that the picture comes later."""
_DISK_ALARM_S = 600.0
"""Ten minutes of recording are left: time to make room."""
_QUEUE_ALARM = 0.5
"""Half full: the disk is too slow, and the other half is what is left before samples are lost."""
_RATE_TOLERANCE = 0.02
"""The rate is measured over half a second of blocks of 20 ms: it is not known better."""


_TIPS = {
    "rate": "Samples per second of each channel, as they really come in",
    "lost": "Samples of each channel that the device lost, or that were not written in time",
    "backlog": "Samples that wait in the device's buffer",
    "queue": "How full the queue to the disk is",
    "disk": "Free space of the disk that is recorded to",
    "lag": "How far the live track is behind the newest sample",
}


class HealthLine(QWidget):
    """One label a figure."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._health: Health | None = None
        self._labels = {name: QLabel() for name in _TIPS}
        for name, label in self._labels.items():
            label.setToolTip(_TIPS[name])
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.run = QLabel()
        self.run.setToolTip("How the last run was recorded")
        self.run.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        # never makes the window wider
        self.run.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        fill(QHBoxLayout(self), *self._labels.values(), (self.run, 1), margins=(6, 0, 6, 0), spacing=18)
        theme.changed.connect(self._write)
        self._write()

    def texts(self) -> dict[str, str]:
        """Return what is shown."""
        return {name: label.text() for name, label in self._labels.items()}

    def show_health(self, health: Health | None) -> None:
        """Show a snapshot; None: nothing runs."""
        self._health = health
        self._write()

    def show_run(self, text: str) -> None:
        """Show how the last run was recorded."""
        self.run.setText(text)
        self.run.setToolTip(f"How the last run was recorded. {text}".strip())

    def _write(self) -> None:
        for name, (text, bad) in figures(self._health).items():
            label = self._labels[name]
            if label.text() != text:
                label.setText(text)
            style = f"color: {self._theme.colours.alarm}; font-weight: bold;" if bad else ""
            if label.styleSheet() != style:
                label.setStyleSheet(style)


def figures(health: Health | None) -> dict[str, tuple[str, bool]]:
    """Return each figure's words and whether it is bad."""
    if health is None:
        words = ("Rate –", "Lost 0", "Backlog 0", "Queue –", "Disk –", "Live lag –")
        return {name: (text, False) for name, text in zip(_TIPS, words, strict=True)}
    promised = health.sample_rate_hz
    # the rate means something only while samples come in, and after a first second
    counts = health.state is AcquisitionState.RUNNING and health.samples_read > (promised or 0.0)
    real = health.read_rate_hz if counts else None
    slow = promised is not None and real is not None and abs(real - promised) > _RATE_TOLERANCE * promised
    lost = health.samples_lost + health.samples_not_written
    full = health.writer_queue_samples / max(1, health.writer_queue_capacity_samples)
    free, left = health.disk_free_bytes, health.disk_left_s
    lag = health.live_lag_s
    skipped = f", {health.live_skipped_samples} skipped" if health.live_skipped_samples else ""
    return {
        "rate": (f"Rate {_rate(real if real is not None else promised)}", slow),
        "lost": (f"Lost {lost} in {health.gaps} gaps" if lost else "Lost 0", lost > 0),
        "backlog": (f"Backlog {health.backlog_samples}", False),
        "queue": (
            f"Queue {full:.0%}" if health.writer_queue_capacity_samples else f"Queue {UNKNOWN}",
            full > _QUEUE_ALARM,
        ),
        "disk": (
            f"Disk {free / 1e9:.1f} GB free" if free is not None else f"Disk {UNKNOWN}",
            left is not None and left < _DISK_ALARM_S,
        ),
        "lag": (
            f"Live lag {1e3 * lag:.0f} ms{skipped}" if lag is not None else f"Live lag {UNKNOWN}",
            lag is not None and lag > _LAG_ALARM_S,
        ),
    }


def _rate(value: float | None) -> str:
    return UNKNOWN if value is None else f"{value / 1e3:.2f} kS/s per channel"
