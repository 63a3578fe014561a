"""Stiffness, mass and damping matrices of other programs, read from their files."""

from vanelock.common import lazy

_modules = {
    "Matrices": "model",
    "load_matrices": "load",
    "load_nodes": "tables",
    "load_pairs": "tables",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
