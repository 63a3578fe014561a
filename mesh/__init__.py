"""Geometry and meshes: vane segment, casing sector, named node sets."""

from vanelock import lazy

_modules = {
    "CasingDimensions": "dimensions",
    "FileMesh": "file_mesh",
    "HookDimensions": "dimensions",
    "Mates": "pairing",
    "AerofoilPoint": "instrument",
    "OwnPart": "own_part",
    "Part": "part",
    "Quality": "tetrahedra",
    "VaneDimensions": "dimensions",
    "casing_sector": "casing",
    "check_fit": "fit",
    "hook_overlap": "patches",
    "on_aerofoil": "instrument",
    "Refinement": "refinement",
    "Sizes": "refinement",
    "sizes_for": "refinement",
    "pair": "pairing",
    "quality": "tetrahedra",
    "read_mesh": "read",
    "read_sector": "sector",
    "vane_segment": "vane",
    "write_msh": "export",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
