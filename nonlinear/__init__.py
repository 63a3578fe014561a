"""Friction contacts, harmonic balance and continuation on a System of arrays."""

import inspect
from collections.abc import Callable
from dataclasses import fields
from functools import cache, wraps
from types import FunctionType
from typing import Any

from vanelock.common import lazy
from vanelock.common.errors import InputError

_modules = {
    "Audit": "audit",
    "Contact": ".rom.system.coordinates",
    "Contacts": ".rom.system.system",
    "Element": ".rom.system.element",
    "ELEMENT": "contact.law",
    "DampedMode": "modes.damped_mode",
    "damped_mode": "modes.damped_mode",
    "LimitCycles": "modes.limit_cycles",
    "aerodynamic_damping": "modes.limit_cycles",
    "limit_cycles": "modes.limit_cycles",
    "Diameter": ".rom.system.system",
    "Force": ".rom.system.system",
    "Hysteresis": "forced_response.hysteresis",
    "PointStore": "forced_response.frequency_sweep",
    "OPEN": "contact.law",
    "Options": "forced_response.options",
    "ParameterResponse": "forced_response.parameter_response",
    "PeakResponse": "peaks.peak_response",
    "Response": "forced_response.response",
    "RingResponse": "forced_response.ring.ring_response",
    "SectorModes": "forced_response.ring.mistuning",
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
    "hysteresis": "forced_response.hysteresis",
    "linear_response": "forced_response.linear_response",
    "neglected_harmonics": "adaptive.error_estimates",
    "parameter_response": "forced_response.parameter_response",
    "PeakBounds": "bounds.peak_bounds",
    "peak_bounds": "bounds.peak_bounds",
    "StaticBounds": "bounds.peak_bounds",
    "static_bounds": "bounds.peak_bounds",
    "AmplitudeGradient": "peaks.amplitude_gradient",
    "amplitude_gradient": "peaks.amplitude_gradient",
    "PeakGradient": "peaks.peak_gradient",
    "peak_gradient": "peaks.peak_gradient",
    "peak_gradient_of": "peaks.peak_gradient",
    "Dwell": "wear.step",
    "WearHistory": "wear.wear_history",
    "wear_history": "wear.wear_history",
    "PeakErrors": "adaptive.interpolant",
    "peak_errors": "adaptive.interpolant",
    "peak_response": "peaks.peak_response",
    "STABLE": "floquet.stability",
    "Stability": "floquet.stability",
    "UNDECIDED": "floquet.stability",
    "Mistuning": "forced_response.ring.mistuning",
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
    return _with_keywords(value) if isinstance(value, FunctionType) else value


@cache
def _with_keywords(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function whose `options`, if it has any, may be given one by one by their names."""
    from vanelock.nonlinear.forced_response.options import Options

    names = list(inspect.signature(function).parameters)
    if "options" not in names:
        return function
    known = [each.name for each in fields(Options) if each.name not in names]

    @wraps(function)
    def called(*args: Any, **keywords: Any) -> Any:
        chosen = {name: keywords.pop(name) for name in list(keywords) if name not in names}
        for name in chosen:
            if name not in known:
                raise InputError(
                    f"{name}: given to {function.__name__}: allowed: {', '.join(names + known)}"
                )
        if not chosen:
            return function(*args, **keywords)
        if "options" in keywords or len(args) > names.index("options"):
            raise InputError(f"options: given, and {', '.join(chosen)} beside: needs one of both")
        return function(*args, options=Options(**chosen), **keywords)

    return called
