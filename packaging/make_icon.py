"""Draw windows/radargui.ico from resources/window/radargui.svg: run by name where the drawing changes."""

import io
import sys
from pathlib import Path

from PIL import Image
from PySide6.QtCore import QBuffer, QIODevice
from PySide6.QtGui import QGuiApplication, QImage, QPainter
from PySide6.QtSvg import QSvgRenderer

HERE = Path(__file__).resolve().parent
application = QGuiApplication([*sys.argv[:1], "-platform", "offscreen"])
image = QImage(256, 256, QImage.Format.Format_ARGB32)
image.fill(0)
painter = QPainter(image)
QSvgRenderer(str(HERE.parent / "resources" / "window" / "radargui.svg")).render(painter)
painter.end()
buffer = QBuffer()
buffer.open(QIODevice.OpenModeFlag.WriteOnly)
image.save(buffer, "PNG")
picture = Image.open(io.BytesIO(bytes(buffer.data().data())))
picture.save(HERE / "windows" / "radargui.ico", sizes=[(side, side) for side in (16, 24, 32, 48, 64, 128, 256)])
