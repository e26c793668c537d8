"""The polarisation of the antennas in the panel: typed, drawn while it is typed, refused where it gets no signal."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from support.typing_keys import line, typed

from radargui.gui.main_window import MainWindow
from radargui.gui.setup.antenna_panel import PolarizationTable
from radargui.gui.setup.fields import Changed
from radargui.model.setup import Setup


def gets(window: MainWindow, receiver: int) -> QLabel:
    """Return what is said at the end of a row."""
    (table,) = window.findChildren(PolarizationTable)
    label = table.rows[receiver][-1]
    assert isinstance(label, QLabel)
    return label


def test_the_words_follow_typing(antennas: MainWindow) -> None:
    assert gets(antennas, 1).text() == ""
    assert line(antennas, "receiver[1].polarization_deg").placeholderText() == "not given"
    typed(antennas, "transmitter.polarization_deg", "30")
    assert antennas.setup_model.setup.transmitter.polarization_deg == 30.0
    typed(antennas, "transmitter.u_polarization_deg", "2,5")
    assert antennas.setup_model.setup.transmitter.u_polarization_deg == 2.5
    strongest = antennas.setup_model.setup.received_fields()[0].strongest_deg
    assert line(antennas, "receiver[1].polarization_deg").placeholderText() == f"strongest, {strongest:.1f}"
    assert gets(antennas, 1).text() == "100 %"
    # half of the field is a quarter of the power; of the field it is said
    typed(antennas, "receiver[1].polarization_deg", f"{(strongest + 60.0) % 180.0:.3f}")
    assert gets(antennas, 1).text() == "50 %"


def test_an_angle_across_the_field_is_refused_at_its_field_with_the_one_that_is_strongest(antennas: MainWindow) -> None:
    antennas.setup_model.assign("tracer.diameter_m", 0.002)
    typed(antennas, "transmitter.polarization_deg", "30")
    field = antennas.setup_model.setup.received_fields()[1]
    typed(antennas, "receiver[2].polarization_deg", f"{(field.strongest_deg + 90.0) % 180.0:.2f}")
    assert not antennas.setup_model.valid
    mark = line(antennas, "receiver[2].polarization_deg").findChild(Changed)
    assert mark is not None
    assert f"{field.strongest_deg:.1f} gives the strongest" in mark.fault
    # refused, and told all the same: that is where it helps
    assert float(gets(antennas, 2).text().removesuffix(" %")) < 5.0
    assert gets(antennas, 2).styleSheet()


def test_a_receivers_angle_without_the_transmitters_is_refused_at_its_own_field(antennas: MainWindow) -> None:
    typed(antennas, "receiver[1].polarization_deg", "20")
    mark = line(antennas, "receiver[1].polarization_deg").findChild(Changed)
    assert mark is not None
    assert "allowed: together with" in mark.fault


def test_all_its_fields_are_reached_by_tab_in_the_order_of_the_rows(antennas: MainWindow) -> None:
    line(antennas, "transmitter.polarization_deg").setFocus()
    reached = []
    for _ in range(8):
        focused = QApplication.focusWidget()
        assert isinstance(focused, QWidget)
        reached.append(focused.objectName())
        QTest.keyClick(focused, Qt.Key.Key_Tab)
    places = ("transmitter", "receiver[1]", "receiver[2]", "receiver[3]")
    assert reached == [f"{place}.{name}" for place in places for name in ("polarization_deg", "u_polarization_deg")]


def test_a_transmitter_off_the_axis_has_a_place_instead_of_a_distance(antennas: MainWindow) -> None:
    model = antennas.setup_model
    assert line(antennas, "transmitter.distance_m").isVisible()
    assert not line(antennas, "transmitter.position_m[1]").isVisible()
    document = model.setup.model_dump(by_alias=True, exclude_none=True)
    document["transmitter"] = {"position_m": (0.01, 0.0, 0.7)}
    model.take(Setup.model_validate(document))
    QApplication.processEvents()
    assert not line(antennas, "transmitter.distance_m").isVisible()
    assert line(antennas, "transmitter.position_m[1]").text() == "10"
    typed(antennas, "transmitter.position_m[2]", "-4")
    assert model.setup.transmitter.position_m == (0.01, -0.004, 0.7)


def test_the_transmitters_angle_can_be_taken_out_while_a_receiver_still_has_one(antennas: MainWindow) -> None:
    typed(antennas, "transmitter.polarization_deg", "0")
    typed(antennas, "receiver[1].polarization_deg", "1")
    typed(antennas, "transmitter.polarization_deg", "")
    assert line(antennas, "transmitter.polarization_deg").text() == ""
    assert "together with" in antennas.setup_model.error
    typed(antennas, "receiver[1].polarization_deg", "")
    assert antennas.setup_model.valid
    assert antennas.setup_model.setup.transmitter.polarization_deg is None
