"""The response of a case with other joints, load, damping or moduli, without reducing anything.

What `[fit]` may vary enters when reduced parts are scaled (`rom.stiffened`) and joined
(`rom.join`); the parts are those of the case. Modes of the stuck structure are computed again only
where stiffness or damping changed.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear, rom
from vanelock.input.cases.values import value_at, with_values
from vanelock.input.measured.curve import Measured
from vanelock.input.measured.units import DISPLACEMENT
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response, System
from vanelock.rom import Component, MeshExcess
from vanelock.rom.system.system import common_band
from vanelock.stages.parts.gauges import Gauges
from vanelock.stages.parts.systems import joining
from vanelock.stages.response.monitor import Monitor

Floats = NDArray[np.float64]


@dataclass
class Rejoined:
    """A case whose joints, load, damping and moduli may be others.

    Parameters
    ----------
    study : Study
        The case, its temperatures known.
    vane, casing : Component
        Its reduced parts.
    monitor : Monitor
        The displacement that is measured.
    gauges : Gauges or None
        The strain gauges, where strains are.
    excess : MeshExcess or None
        What the meshes add to the stiffness of the parts, if it is taken off.
    """

    study: Study
    vane: Component
    casing: Component
    monitor: Monitor
    gauges: Gauges | None = None
    excess: MeshExcess | None = None
    _stiff: tuple[Any, ...] = ()
    _modes: Mapping[int, Any] = field(default_factory=dict)

    def system(self, values: Mapping[str, float]) -> tuple[System, Component, Component]:
        """The system with some keys changed, and its parts."""
        changed = with_values(self.study, dict(values))
        moduli = [
            value_at(changed, f"material.{name}.E") / value_at(self.study, f"material.{name}.E")
            for name in ("vane", "casing")
        ]
        parts = [
            part if factor == 1 else rom.stiffened(part, factor)
            for part, factor in zip((self.vane, self.casing), moduli, strict=True)
        ]
        system = joining(changed).join(*parts)
        if self.excess is not None:
            system = self.excess.taken_off(system, moduli)
        # Moduli that are tried move the band with them; the study's own is what is to hold.
        system = replace(system, band=common_band((self.vane.reach, self.casing.reach)))
        stiff = (
            system.contacts.stiffness.tobytes(),
            *changed.damping.model_dump().values(),
            *moduli,
        )
        if stiff != self._stiff:
            self._stiff, self._modes = stiff, {}
        return system, *parts

    def response(
        self, values: Mapping[str, float], hertz: Floats, direction: str = "up", load: float = 1.0
    ) -> tuple[Response, Component, Component]:
        """Nonlinear response at frequencies (p,), Hz, to a multiple of the load, and the parts."""
        system, vane, casing = self.system(values)
        if load != 1:
            loads = {
                h: replace(force, vector=load * force.vector) for h, force in system.force.items()
            }
            system = replace(system, force=loads)
        options = self.study.response
        if not self._modes:
            self._modes = nonlinear.harmonic_modes(system, options.harmonics).diameters
        found = nonlinear.frequency_response(
            system,
            hertz,
            nonlinear.Options(
                options.harmonics,
                coupling=options.coupling,
                samples=options.samples,
                friction=self.study.response.friction,
                direction=direction,
                harmonic_diameters=options.harmonic_diameters,
                effort=options.effort,
            ),
            modes=self._modes,
            find_jumps=False,
        )
        return found, vane, casing

    def amplitudes(
        self, values: Mapping[str, float], curve: Measured, hertz: Floats | None = None
    ) -> Floats:
        """(p,) amplitudes of a measured quantity at its own frequencies, or others, Hz.

        Not a number where a point did not converge.
        """
        wanted = curve.frequency if hertz is None else hertz
        distinct, places = np.unique(wanted, return_inverse=True)
        response, vane, casing = self.response(values, distinct, curve.direction, curve.load)
        if curve.quantity == DISPLACEMENT:
            found = self.monitor.amplitude(response)
        else:
            assert self.gauges is not None
            strain = self.gauges.read(response, vane, lambda _: casing)
            found = np.where(response.converged, strain.amplitude[:, curve.gauge], np.nan)
        return np.asarray(found[places])
