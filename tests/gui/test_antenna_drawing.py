"""What the antenna panel draws: the setup to scale as it is typed, and the uncertainty to expect."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF
from PySide6.QtWidgets import QApplication
from support.typing_keys import line, typed

from radargui.gui.main_window import MainWindow
from radargui.processing.expected_uncertainty import expected_uncertainty


def has(window: MainWindow, where: QPointF, colour: str) -> bool:
    """Return whether a colour stands at a place, or one pixel beside it: edges are smoothed."""
    image = window.sketch.grab().toImage()
    scale = image.width() / window.sketch.width()
    near = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    x, y = scale * where.x(), scale * where.y()
    return any(image.pixelColor(round(x) + dx, round(y) + dy).name() == colour for dx, dy in near)


def test_the_drawing_is_to_scale_and_follows_the_typing(antennas: MainWindow) -> None:
    sketch, colours = antennas.sketch, antennas.theme.colours
    transmitter, first, second = sketch.places[:3]
    assert transmitter.place_m == pytest.approx([0.0, 0.0, 0.7])
    # 0.7 m at 40 degrees, towards y: on the axis from the side, above the centre from above
    assert first.place_m == pytest.approx(0.7 * np.array([0.0, math.sin(math.radians(40)), math.cos(math.radians(40))]))
    for view, axes in enumerate(((0, 2), (0, 1))):
        away = sketch.at(view, second.place_m) - sketch.at(view, np.zeros(3))
        wanted = sketch.scale() * second.place_m[list(axes)]
        assert (away.x(), -away.y()) == pytest.approx(tuple(wanted), abs=1e-6)
    before = sketch.at(1, first.place_m)
    assert has(antennas, before, colours.receivers[0])
    typed(antennas, "receiver[1].azimuth_deg", "0")
    now = sketch.at(1, sketch.places[1].place_m)
    assert sketch.places[1].place_m[0] == pytest.approx(0.7 * math.sin(math.radians(40)))
    assert has(antennas, now, colours.receivers[0])
    assert not has(antennas, QPointF(now.x(), before.y()), colours.receivers[0])
    assert "Rx 1: x 450, y 0, z 536 mm" in sketch.toolTip()


def test_what_is_edited_is_highlighted(antennas: MainWindow) -> None:
    sketch = antennas.sketch
    for key, name in (
        ("receiver[2].tilt_deg", "receiver[2]"),
        ("receiver[3].polarization_deg", "receiver[3]"),
        ("tracer.release_position_m[2]", "tracer"),
        ("transmitter.distance_m", "transmitter"),
        ("floor.height_m", "floor"),
    ):
        line(antennas, key).setFocus()
        QApplication.processEvents()
        every = [*(one.keys for one in sketch.places), "floor"]
        assert [keys for keys in every if sketch.is_edited(keys)] == [name], key
    line(antennas, "receiver[2].tilt_deg").setFocus()
    QApplication.processEvents()
    # the ring round the mark, off its corners
    ring = sketch.at(1, sketch.places[2].place_m) + QPointF(2.4 * 1.3 * 4.0, 0.0)
    assert has(antennas, ring, antennas.theme.colours.receivers[1])
    line(antennas, "receiver[1].tilt_deg").setFocus()
    QApplication.processEvents()
    assert not has(antennas, ring, antennas.theme.colours.receivers[1])


def test_the_polarisation_is_a_stroke_along_the_field(antennas: MainWindow) -> None:
    sketch = antennas.sketch
    assert all(one.field is None for one in sketch.places)
    typed(antennas, "transmitter.polarization_deg", "90")
    fields = [one.field for one in sketch.places if one.field is not None]
    assert len(fields) == 4
    assert fields[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    for one in sketch.places[1:4]:
        # a wave's field is across its way
        assert one.field is not None
        assert float(one.field @ one.place_m) == pytest.approx(0.0, abs=1e-12)
    end = sketch.at(1, sketch.places[0].place_m + np.array([0.0, 0.08, 0.0]))
    assert has(antennas, end, antennas.theme.colours.text)


def test_a_setup_that_is_wrong_leaves_the_last_drawing(antennas: MainWindow) -> None:
    sketch = antennas.sketch
    typed(antennas, "receiver[1].tilt_deg", "400")
    assert not antennas.setup_model.valid
    # as it was right last: at 40 degrees
    assert sketch.places[1].words == "Rx 1: x 0, y 450, z 536 mm"


def test_the_map_is_the_uncertainty_of_its_places_and_follows_the_setup(own: MainWindow, wait_for: Any) -> None:
    view = own.antennas.map
    own.antennas.sections.reveal(view)
    wait_for(lambda: view.shown is not None)
    first = view.shown
    assert first is not None
    setup = own.setup_model.setup
    # the corner below on the left, from the side; the middle of the edge to the right, from above
    for plane, column, row, place_m in ((0, 0, 0, (-0.15, 0.0, -0.15)), (1, 24, 12, (0.15, 0.0, 0.0))):
        found = expected_uncertainty(np.array([place_m, place_m]).T, setup, setup.simulation.snr_db)
        assert found is not None
        rms_mm = 1e3 * float(np.sqrt((found[0][:, 0] ** 2).mean()))
        assert first.planes_mm[plane, column, row] == pytest.approx(rms_mm, rel=1e-3)
    assert "most of it from antennas, release and wave" in view.words.text()
    # what is drawn is what was computed, x to the right and z upwards
    (image, _) = view._images
    assert image.image[0, 24] == first.planes_mm[0, 24, 0]
    own.setup_model.assign("receiver[1].u_tilt_deg", 5.0)
    wait_for(lambda: view.shown is not first)
    worse = view.shown
    assert worse is not None
    assert worse.release_mm > 0.9 * first.release_mm
    assert np.nanmax(worse.planes_mm) > 2.0 * np.nanmax(first.planes_mm)
    view.snr.setValue(0.0)
    wait_for(lambda: view.shown is not worse)
    noisy = view.shown
    assert noisy is not None
    assert noisy.largest_share == "noise"
    where = view.plots[0].getPlotItem().vb.mapViewToScene(QPointF(0.0, 0.0))
    view.plots[0].scene().sigMouseMoved.emit(where)
    assert view.here.text() == f"x 0 mm, z 0 mm: ±{noisy.planes_mm[0, 12, 12]:.2f} mm a coordinate"
    own.setup_model.remove_receiver(3)
    wait_for(lambda: view.shown is None)
    assert "three receivers" in view.words.text()
    assert not view.plots[0].isVisible()


def test_nothing_is_computed_while_nobody_looks(own_window: MainWindow) -> None:
    own_window.panels.work_in("measure")
    own_window.setup_model.assign("receiver[1].tilt_deg", 41.0)
    own_window.setup_model.assign("simulation.snr_db", 33.0)
    assert not own_window.antennas.map._soon.isActive()
    # what the program knows is not asked for; what was typed stays
    assert own_window.antennas.map.snr.value() == 33.0
    own_window.antennas.map.snr.setValue(25.0)
    own_window.setup_model.assign("simulation.snr_db", 50.0)
    assert own_window.antennas.map.snr.value() == 25.0
    assert own_window.antennas.map.shown is None
