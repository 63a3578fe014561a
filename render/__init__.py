"""Pictures: shapes off-screen with pyvista, curves with matplotlib."""

from vanelock import lazy

_modules = {
    "Circles": "campbell",
    "Crossings": "campbell",
    "Curve": "curve",
    "Dots": "campbell",
    "Family": "campbell",
    "LOOKS": "contact_map",
    "Measured": "convergence",
    "Named": "haigh",
    "Panel": "convergence",
    "Peak": "curve",
    "Wave": "animation",
    "at_instant": "time_steps",
    "campbell_picture": "campbell",
    "casing_drawing": "casing_sheet",
    "contact_map_picture": "contact_map",
    "convergence_picture": "convergence",
    "haigh_picture": "haigh",
    "loop_animation": "tracing",
    "loop_picture": "loops",
    "mesh_picture": "meshes",
    "mode_animation": "animation",
    "mode_picture": "shapes",
    "preload_picture": "preload",
    "response_animation": "animation",
    "response_curves": "curves",
    "response_picture": "shapes",
    "stress_picture": "stresses",
    "utilisation": "preload",
    "vane_drawing": "vane_sheet",
    "wave_name": "annulus",
    "write_pvd": "time_steps",
    "write_step": "time_steps",
    "write_vtu": "export",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
