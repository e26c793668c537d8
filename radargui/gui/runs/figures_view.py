"""The figures of a run in a page of plain text: bounces, free fall, quality of each receiver, warnings."""

from collections.abc import Callable, Iterable
from html import escape

from PySide6.QtWidgets import QTextBrowser

from radargui.gui.theme import Theme
from radargui.model.quality import ChannelQuality
from radargui.model.result import RunResult
from radargui.model.rounding import UNKNOWN, plain, quantity
from radargui.model.uncertainty_budget import SHARES, UncertaintyBudget, budget_rows, variance_shares
from radargui.restitution.site_gravity import site_check

LEAST_SHOWN = 0.005
"""Share of a variance below which a part of the budget is no stripe that anybody would see."""
_STATUS = {"ok": "ok", "no_motion": "no motion", "rejected": "rejected"}


class FiguresView(QTextBrowser):
    """Everything selectable."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._result: RunResult | None = None
        self.notes: tuple[str, ...] = ()
        """How the run was recorded, one line each; written above the figures."""
        self.setOpenLinks(False)
        theme.changed.connect(self._write)

    def show_result(self, result: RunResult) -> None:
        """Write the figures of a result."""
        self._result = result
        self._write()

    def clear(self) -> None:
        """Forget the result."""
        self._result = None
        super().clear()

    def _write(self) -> None:
        if self._result is not None:
            notes = "<br>".join(map(escape, self.notes))
            self.setHtml(f"<p>{notes}</p>{page_of(self._result, self._theme)}")


def page_of(result: RunResult, theme: Theme) -> str:
    """Return the figures as simple HTML."""
    colours = theme.colours
    alarm = f' style="color:{colours.alarm}"' if result.status == "rejected" else ""
    reason = f": {escape(result.reason)}" if result.reason else ""
    preliminary = ", preliminary" if result.preliminary else ""
    parts = [f"<p{alarm}><b>{_STATUS[result.status]}{preliminary}</b>{reason}</p>"]
    parts += _fall(result, theme)
    parts += _bounces(result)
    if result.corrected is not None:
        parts.append(f"<h4>Receivers, correction {escape(result.corrected.method)}</h4>")
        parts.append(_quality(result.corrected.channels))
    if result.uncertainty_budget is not None:
        parts += _budget(result.uncertainty_budget, theme)
    if result.warnings:
        items = "".join(f"<li>{escape(text)}</li>" for text in result.warnings)
        parts.append(f"<h4>Warnings</h4><ul>{items}</ul>")
    return "".join(parts)


def _fall(result: RunResult, theme: Theme) -> list[str]:
    fall = result.bounces.free_fall
    if fall is None:
        return []
    rows = (
        ("g", quantity(fall.g_m_s2, fall.u_g_m_s2, "m/s²")),
        ("Drop height", plain(fall.drop_height_m, unit="mm", scale=1000.0)),
        ("Residual of the parabola, rms", plain(fall.residual_rms_m, 3, unit="µm", scale=1e6)),
    )
    parts, check = [f"<h4>First fall</h4>{_table(rows, left=0)}"], site_check(result)
    if check is not None:
        alarm = f' style="color:{theme.colours.alarm}"' if check.agrees is False else ""
        parts.append(f"<p{alarm}>g against the site: {escape(check.compared)}</p>")
    return parts


def _bounces(result: RunResult) -> list[str]:
    impacts = result.bounces.impacts
    if not impacts:
        return ["<p>No bounce.</p>"] if result.status == "ok" else []
    zero, since = result.zero
    rows = (
        (
            str(number),
            f"{bounce.time_s - zero:.4f}",
            plain(bounce.speed_before_m_s),
            plain(bounce.speed_after_m_s),
            f"<b>{quantity(bounce.e, bounce.u_stated)}</b>",
            plain(bounce.u_e, 2),
            "" if bounce.valid else "not valid",
        )
        for number, bounce in enumerate(impacts, start=1)
    )
    head = ("Bounce", "t [s]", "Before [m/s]", "After [m/s]", "e ± combined u", "Statistical u", "")
    methods = ", ".join(sorted({bounce.method for bounce in impacts}))
    words = f"<p>t counts from {since}; speeds by {escape(methods)}</p>"
    return ["<h4>Bounces</h4>", words, _table(rows, head, left=6)]


def _budget(budget: UncertaintyBudget, theme: Theme) -> list[str]:
    parts = [f"<h4>Standard uncertainties</h4>{_table(map(escape, cells) for cells in budget_rows(budget))}"]
    colours = dict(zip(SHARES, (theme.colours.i, theme.colours.q, theme.colours.fit), strict=True))
    for name, line in (("e", budget.e), ("g", budget.g_m_s2), ("position", budget.position_m)):
        shares = {share: round(100.0 * part) for share, part in variance_shares(line).items() if part >= LEAST_SHOWN}
        if shares:
            bar = "".join(
                f"<td width='{part}%' bgcolor='{colours[share]}'>&nbsp;</td>" for share, part in shares.items()
            )
            said = ", ".join(f"{share} {part} %" for share, part in shares.items())
            parts.append(f"<p>What makes u of {name}, by squares: {said}</p>")
            parts.append(f"<table width='100%' cellspacing='0'><tr>{bar}</tr></table>")
    if budget.assumed:
        said = ", ".join(f"{key} {plain(value, 2)}" for key, value in budget.assumed.items())
        parts.append(f"<p>Assumed, because the setup does not say: {escape(said)}</p>")
    return parts


def _quality(channels: tuple[ChannelQuality, ...]) -> str:
    def share(value: float | None) -> str:
        return UNKNOWN if value is None else f"{100.0 * value:.1f}"

    figures: dict[str, Callable[[ChannelQuality], str]] = {
        "SNR [dB]": lambda one: plain(one.snr_db, 3),
        "Departure from the circle, rms [amplitudes]": lambda one: plain(one.circularity, 2),
        "Image rejection [dB]": lambda one: plain(one.image_rejection_db, 3),
        "Fringes": lambda one: plain(one.fringes, 3),
        "Gain Q / I": lambda one: quantity(one.gain_ratio, one.u_gain_ratio),
        "Quadrature error [°]": lambda one: quantity(one.quadrature_error_deg, one.u_quadrature_error_deg),
        "Valid samples [%]": lambda one: share(one.fraction_valid),
        "Clipped samples [%]": lambda one: share(one.fraction_clipped),
        "Verdict": lambda one: escape(one.verdict),
    }
    head = ("", *(f"Rx {escape(channel.name)}" for channel in channels))
    rows = ((words, *map(figure, channels)) for words, figure in figures.items())
    reasons = (f"<p>Rx {escape(one.name)}: {escape(one.reason)}</p>" for one in channels if one.reason)
    return _table(rows, head, left=0) + "".join(reasons)


def _table(rows: Iterable[Iterable[str]], head: Iterable[str] = (), left: int = -1) -> str:
    """Return a table of simple HTML whose cells stand at the right, those of the column `left` at the left."""

    def line(cells: Iterable[str], tag: str) -> str:
        sides = ((text, "left" if column == left else "right") for column, text in enumerate(cells))
        return "<tr>" + "".join(f"<{tag} align='{side}'>&nbsp;{text}</{tag}>" for text, side in sides) + "</tr>"

    return (
        f"<table cellspacing='0' cellpadding='2'>{line(head, 'th')}{''.join(line(row, 'td') for row in rows)}</table>"
    )
