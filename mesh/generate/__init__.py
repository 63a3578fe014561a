"""Geometry and meshes of the program's own vane and casing, by gmsh."""
