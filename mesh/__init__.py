"""Geometry and meshes: vane segment, casing sector, named node sets."""

from vanelock.common import lazy

_modules = {
    "CasingDimensions": "geometry.dimensions",
    "FileMesh": "files.raw",
    "HookDimensions": "geometry.dimensions",
    "Mates": "matching.pairing",
    "AerofoilPoint": "geometry.aerofoil",
    "OwnPart": "matching.side",
    "Part": "part",
    "Quality": "cells",
    "VaneDimensions": "geometry.dimensions",
    "casing_sector": "generate.casing",
    "check_fit": "checks",
    "hook_overlap": "contact_patches",
    "on_aerofoil": "geometry.aerofoil",
    "pair": "matching.pairing",
    "quality": "cells",
    "read_mesh": "files.read",
    "read_sector": "matching.pairing",
    "vane_segment": "generate.vane",
    "write_msh": "files.exchange",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
