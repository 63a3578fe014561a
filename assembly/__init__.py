"""Scenes of other people's models: matrices from files, contacts by node lists, to a response."""

from vanelock import lazy

_modules = {
    "Scene": "model",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
