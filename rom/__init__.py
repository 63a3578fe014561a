"""Reduced-order models: Craig-Bampton, cyclic symmetry, Tran, joining components, recovery."""

from vanelock import lazy

_modules = {
    "Contacts": "system",
    "Diameter": "system",
    "Force": "system",
    "System": "system",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
