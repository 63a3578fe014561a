"""Linear elasticity: stiffness and mass, sparse factorisation, linear modes."""

from vanelock import lazy

_modules = {
    "Factor": "factor",
    "Material": "material",
    "Model": "model",
    "Modes": "vibration",
    "assemble": "assembly",
    "backends": "factor",
    "cyclic_faces": "symmetry",
    "cyclic_transform": "symmetry",
    "eigenpairs": "eigen",
    "factorise": "factor",
    "modes": "vibration",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
