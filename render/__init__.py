"""Pictures: shapes off-screen with pyvista, curves with matplotlib."""

from vanelock import lazy

_modules = {
    "Curve": "curve",
    "Peak": "curve",
    "Measured": "convergence",
    "Panel": "convergence",
    "Circles": "campbell",
    "Crossings": "campbell",
    "Dots": "campbell",
    "Family": "campbell",
    "campbell_picture": "campbell",
    "casing_drawing": "casing_sheet",
    "convergence_picture": "convergence",
    "loop_picture": "loops",
    "mesh_picture": "meshes",
    "mode_picture": "shapes",
    "preload_picture": "preload",
    "response_curves": "curves",
    "response_picture": "shapes",
    "stress_picture": "stresses",
    "utilisation": "preload",
    "vane_drawing": "vane_sheet",
    "wave_name": "annulus",
    "write_vtu": "export",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
