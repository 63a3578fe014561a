"""VTK without a screen: whether this machine can draw, found out before VTK is loaded.

Without an OpenGL library VTK ends the whole process with a segmentation fault at its first
picture, so the libraries are looked for first, then one small picture is drawn in a process of
its own: a library may be there and its driver not. Software drawing (Mesa) is enough.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from types import ModuleType
from typing import Final

from vanelock.common.errors import InputError
from vanelock.common.process import missing_libraries

INSTALL: Final = "apt-get install libgl1 libegl1 libgl1-mesa-dri"
LIBRARIES: Final = ("libGL.so.1", "libEGL.so.1")
_SWITCH: Final = "VTK_DEFAULT_OPENGL_WINDOW"
_WINDOWS: Final = ("vtkEGLRenderWindow", "")  # "": VTK's own choice
_PROBE: Final = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkRenderer, vtkWindowToImageFilter
window, renderer, picture = vtkRenderWindow(), vtkRenderer(), vtkWindowToImageFilter()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
renderer.SetBackground(1.0, 0.0, 0.0)
window.AddRenderer(renderer)
window.Render()
picture.SetInput(window)
picture.Update()
red = [picture.GetOutput().GetScalarComponentAsDouble(4, 4, 0, i) for i in range(3)]
raise SystemExit(0 if red == [255, 0, 0] else 3)
"""


def pyvista() -> ModuleType:
    """`pyvista`, once it is certain that a picture can be drawn here."""
    _render_window()
    import pyvista

    return pyvista


def _render_window() -> str:
    """VTK window class that draws off-screen here; "" where VTK's own choice does."""
    return trial().result()


@lru_cache(maxsize=1)
def trial() -> Future[str]:
    """The trial under way, once a process; begun early, it costs no waiting when it is needed."""
    return ThreadPoolExecutor(1).submit(_tried)


def _tried() -> str:
    if sys.platform != "linux":
        return ""
    if missing_libraries(LIBRARIES) == list(LIBRARIES):
        raise InputError(
            f"pictures: neither {' nor '.join(LIBRARIES)} can be loaded: "
            f"install OpenGL by `{INSTALL}`"
        )
    for window in _WINDOWS:
        if _draws(window):
            return window
    raise InputError(
        "pictures: VTK cannot draw off-screen with the OpenGL libraries found here: "
        f"install software drawing by `{INSTALL}`"
    )


def _draws(window: str, program: str = _PROBE) -> bool:
    """Whether a process of its own draws one small picture with that VTK window class."""
    environment = {key: value for key, value in os.environ.items() if key != _SWITCH}
    if window:
        environment[_SWITCH] = window
    try:
        done = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, timeout=120
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


@contextmanager
def selected() -> Iterator[None]:
    """Let VTK make the windows of this block of the class that draws here, then restore."""
    before = os.environ.get(_SWITCH)
    window = _render_window()
    if window:
        os.environ[_SWITCH] = window
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(_SWITCH, None)
        else:
            os.environ[_SWITCH] = before
