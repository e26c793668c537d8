"""The test of OpenGL, run in a process of its own because a bad driver can take the process with it."""

from __future__ import annotations

import sys

WORD = "opengl usable"
SOFTWARE = "opengl in software"
_SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swrast", "swiftshader", "gdi generic", "basic render")
LEAST_VERSION = (2, 1)


def check(arguments: list[str]) -> str:
    """Return `WORD` where a 3D view will work, `SOFTWARE` where it will be slow, else why not, in a few words."""
    from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

    application = QGuiApplication(arguments)
    if application.platformName() in {"offscreen", "minimal", "vnc"}:
        return f"no OpenGL on the platform {application.platformName()}"
    context = QOpenGLContext()
    context.setFormat(QSurfaceFormat.defaultFormat())
    if not context.create():
        return "no OpenGL context could be made"
    surface = QOffscreenSurface()
    surface.setFormat(context.format())
    surface.create()
    if not context.makeCurrent(surface):
        return "the OpenGL context could not be used"
    try:
        version = context.format().version()
        if version < LEAST_VERSION:
            return f"OpenGL {version[0]}.{version[1]} is too old"
        from OpenGL.platform import PLATFORM

        if not PLATFORM.GetCurrentContext():
            return "PyOpenGL does not see the context"
        from OpenGL.GL import GL_RENDERER, glGetString

        renderer = (glGetString(GL_RENDERER) or b"").decode("ascii", "replace").lower()
        if any(name in renderer for name in _SOFTWARE_NAMES):
            return SOFTWARE
    finally:
        context.doneCurrent()
    return WORD


def main() -> int:
    """Write the answer to standard output."""
    sys.stdout.write(check(sys.argv[:1]) + "\n")
    sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
