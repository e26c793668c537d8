"""The test of OpenGL, run in a process of its own because a bad driver can take the process with it."""

import sys

USABLE, SOFTWARE, UNUSABLE = 40, 41, 42
"""Exit statuses: a program without a console has no standard output to answer on."""
_SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swrast", "swiftshader", "gdi generic", "basic render")
LEAST_VERSION = (2, 1)


def check(arguments: list[str]) -> tuple[int, str]:
    """Return whether a 3D view will work, or work slowly (`SOFTWARE`), and the renderer or why not in a few words."""
    from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

    application = QGuiApplication(arguments)
    if application.platformName() in {"offscreen", "minimal", "vnc"}:
        return UNUSABLE, f"no OpenGL on the platform {application.platformName()}"
    context = QOpenGLContext()
    context.setFormat(QSurfaceFormat.defaultFormat())
    if not context.create():
        return UNUSABLE, "no OpenGL context could be made"
    surface = QOffscreenSurface()
    surface.setFormat(context.format())
    surface.create()
    if not context.makeCurrent(surface):
        return UNUSABLE, "the OpenGL context could not be used"
    try:
        version = context.format().version()
        if version < LEAST_VERSION:
            return UNUSABLE, f"OpenGL {version[0]}.{version[1]} is too old"
        from OpenGL.platform import PLATFORM

        if not PLATFORM.GetCurrentContext():
            return UNUSABLE, "PyOpenGL does not see the context"
        from OpenGL.GL import GL_RENDERER, glGetString

        renderer = (glGetString(GL_RENDERER) or b"").decode("ascii", "replace")
    finally:
        context.doneCurrent()
    slow = any(name in renderer.lower() for name in _SOFTWARE_NAMES)
    return SOFTWARE if slow else USABLE, f"OpenGL {version[0]}.{version[1]} by {renderer}"


def main() -> int:
    """Return the answer; its words go to standard output where there is one."""
    status, words = check(sys.argv[:1])
    if sys.stdout is not None:
        sys.stdout.write(words + "\n")
        sys.stdout.flush()
    return status


if __name__ == "__main__":
    sys.exit(main())
