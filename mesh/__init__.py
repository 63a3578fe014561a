"""Geometry and meshes: vane segment, casing sector, named node sets."""

from vanelock import lazy

_modules = {"Part": "part"}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
