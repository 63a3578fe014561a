"""Friction contacts, harmonic balance and continuation on a System of arrays."""

from vanelock import lazy

_modules = {
    "OPEN": "law",
    "Response": "response",
    "SLIP": "law",
    "SLIP_OPEN": "law",
    "STUCK": "law",
    "System": "system",
    "frequency_response": "sweep",
    "linear_response": "linear",
    "static_response": "sweep",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
