"""Friction contacts, harmonic balance and continuation on a System of arrays."""

from vanelock import lazy

_modules = {
    "Contacts": "system",
    "Diameter": "system",
    "Force": "system",
    "OPEN": "law",
    "Response": "response",
    "SLIP": "law",
    "SLIP_OPEN": "law",
    "STUCK": "law",
    "System": "system",
    "contact_loop": "loops",
    "frequency_response": "forced",
    "linear_response": "linear",
    "static_response": "forced",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
