"""Friction contacts, harmonic balance and continuation on a System of arrays."""

from vanelock import lazy

_modules = {
    "Audit": "audit",
    "Contacts": "system",
    "Diameter": "system",
    "Force": "system",
    "Hysteresis": "branches",
    "Journal": "replay",
    "OPEN": "law",
    "ParameterResponse": "parametric",
    "PeakResponse": "backbone",
    "Response": "response",
    "SLIP": "law",
    "SLIP_OPEN": "law",
    "STUCK": "law",
    "System": "system",
    "TimeResponse": "transient",
    "ErrorEstimates": "response",
    "SOURCES": "estimates",
    "Shares": "pointwise",
    "adaptive_response": "adaptive",
    "audit_response": "audit",
    "contact_loop": "loops",
    "frequency_response": "forced",
    "hysteresis": "branches",
    "linear_response": "linear",
    "parameter_response": "parametric",
    "PeakErrors": "certainty",
    "peak_errors": "certainty",
    "peak_response": "backbone",
    "static_response": "forced",
    "stuck_modes": "stuck",
    "time_response": "transient",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
