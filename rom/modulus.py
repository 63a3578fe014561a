"""A reduced part of another Young's modulus, without reducing it again.

A part of one material whose modulus E becomes sE, Poisson's ratio and density as they were, has the
stiffness sK and the mass M. Constraint modes -K_ss⁻¹ K_sm, fixed-interface modes of (K_ss, M_ss),
their static answers K_ss⁻¹ M_ss B and the modes of the cyclic faces all span what they spanned, so
the reduced matrices follow exactly:

    K → s K,    M → M,    frequencies → √s,

and of what the reduction leaves out (`errors.frequency_errors`: ε = rᴴ K_ss⁻¹ r, with a residual r
that is partly stiffness and partly inertia force)

    G₀ → s G₀,    G₁ → G₁,    G₂ → G₂ / s.

Static answers to loads at rest span what they spanned, too; a load of thermal strain grows with E.
"""

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from vanelock.common.errors import InputError
from vanelock.rom.component import Component, Reduced


def stiffened(component: Component, factor: float, strained: Collection[str] = ()) -> Component:
    """The same part with Young's modulus times `factor`, at all its nodal diameters.

    Parameters
    ----------
    component : Component
        The part as it was reduced. What it keeps stays the same, so the frequency up to which it
        is accurate moves by √factor.
    factor : float
        New modulus over old, > 0.
    strained : collection of str
        Names of its loads at rest that are of thermal strain.

    Raises
    ------
    InputError
        If the factor is not positive and finite.
    """
    if not (factor > 0 and math.isfinite(factor)):
        raise InputError(f"factor = {factor:g}: Young's modulus must stay > 0 and finite")
    band = None if component.band is None else component.band * math.sqrt(factor)
    diameters = {k: _stiffened(each, factor) for k, each in component.diameters.items()}
    loads = component.loads and {
        name: factor * load if name in strained else load for name, load in component.loads.items()
    }
    return replace(component, diameters=diameters, band=band, loads=loads)


def _stiffened(reduced: Reduced, s: float) -> Reduced:
    neglected = reduced.neglected
    if neglected is not None:
        neglected = neglected * np.array([s, 1.0, 1 / s])[:, None, None]
    complete = None if reduced.complete is None else reduced.complete * math.sqrt(s)
    return replace(reduced, K=s * reduced.K, neglected=neglected, complete=complete)
