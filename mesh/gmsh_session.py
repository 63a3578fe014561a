"""The one place that loads gmsh: its system libraries, its sessions, its options."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vanelock.common.errors import InputError
from vanelock.common.process import missing_libraries, preserved

_PACKAGES = "libglu1-mesa libxft2 libxcursor1 libxinerama1 libgomp1 libgl1"
_LIBRARIES = (
    "libGLU.so.1",
    "libGL.so.1",
    "libX11.so.6",
    "libXext.so.6",
    "libXrender.so.1",
    "libXfixes.so.3",
    "libXcursor.so.1",
    "libXft.so.2",
    "libXinerama.so.1",
    "libfontconfig.so.1",
    "libgomp.so.1",
)

# gmsh keeps one model list and one option table for the whole process.
_session = threading.Lock()

_OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,  # the same mesh, bit for bit, on every machine and in every call
    "Geometry.OCCUnionUnify": 0,  # no faces or edges merge that the geometry tells apart
    "Mesh.RandomSeed": 1,
    "Mesh.Algorithm": 5,  # Delaunay on surfaces
    "Mesh.Algorithm3D": 10,  # HXT: a fifth fewer nodes than Delaunay at the same size and error
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.SecondOrderLinear": 0,  # mid-side nodes on the geometry
}


def load() -> Any:
    """The gmsh module."""
    if missing := missing_libraries(_LIBRARIES):
        raise InputError(
            f"gmsh: system libraries {', '.join(missing)} are missing: "
            f"run `apt-get install -y {_PACKAGES}`"
        )
    try:
        import gmsh
    except (ImportError, OSError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"gmsh: cannot be loaded ({reason}): run `pip install gmsh` "
            f"and `apt-get install -y {_PACKAGES}`"
        ) from None
    return gmsh


@contextmanager
def session(part: str) -> Iterator[Any]:
    """A fresh gmsh, quiet and deterministic, closed again whatever happens.

    Sessions of several threads wait for one another. Configuration files of the user's are not
    read, and no signal handler is changed; it works outside the main thread, too.
    """
    gmsh = load()
    with _session:
        if gmsh.isInitialized():
            raise InputError(
                f"{part}: gmsh is already initialised in this process: "
                "call gmsh.finalize() before meshing"
            )
        with preserved():  # most of them would be back at their defaults
            gmsh.initialize(readConfigFiles=False, interruptible=False)
        try:
            for name, value in _OPTIONS.items():
                gmsh.option.setNumber(name, value)
            gmsh.model.add(part)
            yield gmsh
        except InputError:
            raise
        except Exception as error:
            # gmsh reports every failure as a bare Exception.
            if type(error) is not Exception:
                raise
            reason = (str(error).splitlines() or ["no reason given"])[0]
            raise InputError(f"{part}: these dimensions cannot be meshed ({reason})") from None
        finally:
            gmsh.finalize()
