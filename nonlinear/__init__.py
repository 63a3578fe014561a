"""Friction contacts, harmonic balance and continuation on a System of arrays."""

from vanelock.common import lazy

_modules = {
    "Audit": "verification.audit",
    "Contacts": ".rom.system",
    "Diameter": ".rom.system",
    "Force": ".rom.system",
    "Hysteresis": "following.hysteresis",
    "Journal": "forced_response.replay",
    "OPEN": "contact.law",
    "Options": "forced_response.options",
    "ParameterResponse": "following.parameter_response",
    "PeakResponse": "following.peak_response",
    "Response": "forced_response.response",
    "SLIP": "contact.law",
    "SLIP_OPEN": "contact.law",
    "STUCK": "contact.law",
    "System": ".rom.system",
    "TimeResponse": "transient.time_response",
    "ErrorEstimates": "forced_response.response",
    "SOURCES": "adaptive.error_estimates",
    "Shares": "adaptive.points",
    "adaptive_response": "adaptive.adaptive_response",
    "audit_response": "verification.audit",
    "contact_loop": "forced_response.hysteresis_loop",
    "frequency_response": "forced_response.frequency_response",
    "HarmonicModes": "balance.stuck_modes",
    "harmonic_modes": "balance.stuck_modes",
    "hysteresis": "following.hysteresis",
    "linear_response": "forced_response.linear_response",
    "parameter_response": "following.parameter_response",
    "PeakErrors": "adaptive.peak_errors",
    "peak_errors": "adaptive.peak_errors",
    "peak_response": "following.peak_response",
    "static_response": "forced_response.frequency_response",
    "stuck_modes": "balance.stuck_modes",
    "time_response": "transient.time_response",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
