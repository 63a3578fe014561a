"""Friction contacts, harmonic balance and continuation on a System of arrays."""

from types import FunctionType
from typing import Any

from vanelock.common import lazy

_modules = {
    "Audit": "audit",
    "Contact": ".rom.system.coordinates",
    "Contacts": ".rom.system.system",
    "Element": ".rom.system.element",
    "ELEMENT": "contact.law",
    "DampedMode": "following.modes.damped_mode",
    "damped_mode": "following.modes.damped_mode",
    "LimitCycles": "following.modes.limit_cycles",
    "aerodynamic_damping": "following.modes.limit_cycles",
    "limit_cycles": "following.modes.limit_cycles",
    "Diameter": ".rom.system.system",
    "Force": ".rom.system.system",
    "Hysteresis": "following.hysteresis",
    "PointStore": "forced_response.frequency_sweep",
    "OPEN": "contact.law",
    "Options": "forced_response.options",
    "ParameterResponse": "following.parameter_response",
    "PeakResponse": "following.peak_response",
    "Response": "forced_response.response",
    "RingResponse": "forced_response.ring.ring_response",
    "SectorModes": "forced_response.ring.unlike",
    "MODULATED": "transient.settled_response",
    "SettledResponse": "transient.settled_response",
    "SLIP": "contact.law",
    "SLIP_OPEN": "contact.law",
    "STEADY": "transient.settled_response",
    "STUCK": "contact.law",
    "System": ".rom.system.system",
    "TimeResponse": "transient.time_response",
    "ErrorEstimates": "forced_response.response",
    "SOURCES": "adaptive.error_estimates",
    "Shares": "adaptive.points",
    "adaptive_response": "adaptive.adaptive_response",
    "audit_response": "audit",
    "contact_loop": "forced_response.hysteresis_loop",
    "frequency_response": "forced_response.frequency_response",
    "HarmonicModes": "balance.stuck_modes",
    "harmonic_modes": "balance.stuck_modes",
    "hysteresis": "following.hysteresis",
    "linear_response": "forced_response.linear_response",
    "neglected_harmonics": "adaptive.error_estimates",
    "parameter_response": "following.parameter_response",
    "PeakBounds": "following.bounds.peak_bounds",
    "peak_bounds": "following.bounds.peak_bounds",
    "StaticBounds": "following.bounds.peak_bounds",
    "static_bounds": "following.bounds.peak_bounds",
    "AmplitudeGradient": "following.amplitude_gradient",
    "amplitude_gradient": "following.amplitude_gradient",
    "PeakGradient": "following.peak_gradient",
    "peak_gradient": "following.peak_gradient",
    "peak_gradient_of": "following.peak_gradient",
    "Dwell": "following.wear.step",
    "WearHistory": "following.wear.wear_history",
    "wear_history": "following.wear.wear_history",
    "PeakErrors": "adaptive.interpolant",
    "peak_errors": "adaptive.interpolant",
    "peak_response": "following.peak_response",
    "STABLE": "floquet.stability",
    "Stability": "floquet.stability",
    "UNDECIDED": "floquet.stability",
    "Unlike": "forced_response.ring.unlike",
    "UNSETTLED": "transient.settled_response",
    "UNSTABLE": "floquet.stability",
    "ring_modes": "forced_response.ring.ring_source",
    "ring_response": "forced_response.ring.ring_response",
    "settled_response": "transient.settled_response",
    "stability": "floquet.stability",
    "static_response": "forced_response.frequency_response",
    "stuck_modes": "balance.stuck_modes",
    "time_response": "transient.time_response",
    "whitehead": "forced_response.ring.ring_response",
}
__all__ = list(_modules)
_attribute, __dir__ = lazy.attributes(__name__, _modules)


def __getattr__(name: str) -> Any:
    value = _attribute(name)
    if not isinstance(value, FunctionType):
        return value
    from vanelock.nonlinear.forced_response.options import with_keywords

    return with_keywords(value)
