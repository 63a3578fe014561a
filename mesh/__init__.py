"""Geometry and meshes: vane segment, casing sector, named node sets."""

from vanelock.common import lazy

_modules = {
    "CasingDimensions": "geometry.dimensions",
    "FileMesh": "files.raw",
    "HookDimensions": "geometry.dimensions",
    "Mates": "matching.pairing",
    "AerofoilPoint": "geometry.gauge_places",
    "OwnPart": "matching.own_part",
    "Part": "part",
    "Quality": "checks.tetrahedra",
    "VaneDimensions": "geometry.dimensions",
    "casing_sector": "generate.casing",
    "check_fit": "checks.dimensions",
    "hook_overlap": "contact.patches",
    "on_aerofoil": "geometry.gauge_places",
    "Refinement": "refinement.element_sizes",
    "Sizes": "refinement.element_sizes",
    "sizes_for": "refinement.element_sizes",
    "pair": "matching.pairing",
    "quality": "checks.tetrahedra",
    "read_mesh": "files.read",
    "read_sector": "matching.sector",
    "vane_segment": "generate.vane",
    "write_msh": "files.export",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
