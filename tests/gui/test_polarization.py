"""The polarisation of the antennas in the panel: typed, drawn while it is typed, refused where it gets no signal."""

from __future__ import annotations

import math

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget
from support.typing_keys import line, typed

from radargui.gui.main_window import MainWindow
from radargui.gui.setup.antenna_panel import PolarizationSketch
from radargui.gui.setup.fields import Changed
from radargui.gui.theme import ThemeChoice
from radargui.model.setup import Setup


def sketch_of(window: MainWindow) -> PolarizationSketch:
    (sketch,) = window.findChildren(PolarizationSketch)
    return sketch


def coloured(window: MainWindow, angle_deg: float) -> int:
    """Return how many of 18 places along the transmitter's dial in this direction have the colour of its arrow."""
    sketch, colour = sketch_of(window), window.theme.colours.text
    image = sketch.grab().toImage()
    scale, middle_x = image.width() / sketch.width(), 0.5 * sketch.width() / len(sketch.antennas)

    def has_it(radius: float) -> bool:
        x, y = radius * math.cos(math.radians(angle_deg)), radius * math.sin(math.radians(angle_deg))
        # edges are smoothed: one pixel near must have it
        near = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        places = [(scale * (middle_x + x) + dx, scale * (sketch.middle_y - y) + dy) for dx, dy in near]
        return any(image.pixelColor(round(px), round(py)).name() == colour for px, py in places)

    return sum(has_it(float(radius)) for radius in range(4, 22))


def test_the_drawing_follows_typing_and_says_in_words_what_it_shows(antennas: MainWindow) -> None:
    sketch = sketch_of(antennas)
    assert sketch.accessibleDescription().splitlines()[0] == "Tx: not given"
    typed(antennas, "transmitter.polarization_deg", "30")
    assert antennas.setup_model.setup.transmitter.polarization_deg == 30.0
    typed(antennas, "transmitter.u_polarization_deg", "2,5")
    words = sketch.accessibleDescription().splitlines()
    assert words[0] == "Tx: 30.0° ± 2.5° from x towards y"
    strongest = antennas.setup_model.setup.received_fields()[0].strongest_deg
    assert words[1] == f"Rx 1: {strongest:.1f}° ± 5° from h towards v, 100 % of the strongest signal"
    assert line(antennas, "receiver[1].polarization_deg").placeholderText() == f"strongest, {strongest:.1f}"


@pytest.mark.parametrize("look", ["light", "dark"])
def test_the_arrow_points_where_the_angle_says_in_both_themes(antennas: MainWindow, look: ThemeChoice) -> None:
    antennas.theme.apply(look)
    typed(antennas, "transmitter.polarization_deg", "60")
    QApplication.processEvents()
    assert coloured(antennas, 60.0) > 12
    assert coloured(antennas, 240.0) > 12
    assert coloured(antennas, 120.0) < 3


def test_an_angle_across_the_field_is_refused_at_its_field_with_the_one_that_is_strongest(antennas: MainWindow) -> None:
    antennas.setup_model.assign("tracer.diameter_m", 0.002)
    typed(antennas, "transmitter.polarization_deg", "30")
    field = antennas.setup_model.setup.received_fields()[1]
    typed(antennas, "receiver[2].polarization_deg", f"{(field.strongest_deg + 90.0) % 180.0:.2f}")
    assert not antennas.setup_model.valid
    mark = line(antennas, "receiver[2].polarization_deg").findChild(Changed)
    assert mark is not None
    assert f"{field.strongest_deg:.1f} gives the strongest" in mark.fault.text()
    # refused, and drawn all the same: that is where the drawing helps
    share = sketch_of(antennas).antennas[2].share
    assert share is not None
    assert share < 0.05


def test_a_receivers_angle_without_the_transmitters_is_refused_at_its_own_field(antennas: MainWindow) -> None:
    typed(antennas, "receiver[1].polarization_deg", "20")
    mark = line(antennas, "receiver[1].polarization_deg").findChild(Changed)
    assert mark is not None
    assert "allowed: together with" in mark.fault.text()


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
