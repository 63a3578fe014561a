"""Time histories of a contact over one period."""

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.isotropic_law import slider_places
from vanelock.nonlinear.contact.law import ELEMENT, contact_law
from vanelock.nonlinear.contact.orthogonal_law import (
    BEGIN,
    FREE,
    HELD,
    HIGH,
    KIND,
    LOW,
    PLACE,
    WIDTH,
    slider_path,
)
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, basis, grid, roots, to_real
from vanelock.rom.system.system import Contacts

_AGREEMENT = 1e-6  # of the law with the response's forces, as displacements, to the point's largest


def contact_loop(
    response: Response, point: int, contact: int, samples: int = 512
) -> tuple[Floats, Floats]:
    """Displacements and forces of one contact over a period, for hysteresis loops.

    Parameters
    ----------
    response : Response
    point, contact : int
        Which frequency and which contact.
    samples : int
        Number of equal steps of the period.

    Returns
    -------
    displacement : (samples, 3) float
        v, u1, u2, interference included, m.
    force : (samples, 3) float
        n, t1, t2, N: exact at every instant.

    Raises
    ------
    InputError
        If the point or the contact does not exist, the point has not converged, or its forces are
        not those of the contact law: a linear limit that pulls or sticks beyond the bound of
        friction, or orthogonal friction on plain samples.
    """
    counts = {"point": response.points, "contact": len(response.mu)}
    for (name, count), given in zip(counts.items(), (point, contact), strict=True):
        if not -count <= given < count:
            raise InputError(f"{name}: given {given}: there are {count}, counted from 0")
    u = to_real(response.contact[point, :, contact])
    _check(response, point, contact, u)
    angle = TURN * np.arange(samples) / samples
    displacement = basis(response.harmonics, angle) @ u.T
    stiffness = response.stiffness[contact]
    bounding = u.copy()  # the normal displacement that bounds friction
    lifted = displacement[:, 0] <= 0
    normal = np.maximum(displacement[:, 0], 0.0)
    if response.coupling == "constant-load":
        bounding[0, 1:] = 0.0
        lifted = np.full(samples, u[0, 0] <= 0)
        normal = np.where(lifted, 0.0, displacement[:, 0])
    alpha = response.mu[contact] * stiffness[0] / stiffness[1:]
    if response.friction == "orthogonal":
        pairs = zip(bounding[1:], alpha, strict=True)
        each = [_slider_history(bounding[0], moved, a, angle) for moved, a in pairs]
        place = np.column_stack(each)
    else:
        place = slider_places(bounding, float(alpha[0]), angle)
    force = stiffness * np.column_stack([normal, displacement[:, 1:] - place])
    force[lifted] = 0.0
    return displacement, force


def _check(response: Response, point: int, contact: int, u: Floats) -> None:
    """Refuse a point whose forces are not those that the loop would show."""
    if not response.converged[point]:
        raise InputError(
            f"point: given {point}: not converged (residual {response.residual[point]:.1e}); "
            "a loop needs a converged one"
        )
    if response.state[point, contact] == ELEMENT:
        raise InputError(
            f"contact: given {contact}: an element, whose law a response does not hold"
        )
    stiffness = response.stiffness[[contact]]
    made = Contacts(stiffness[:, 0], stiffness[:, 1:], response.mu[[contact]], np.zeros(1))
    constant_load = response.coupling == "constant-load"
    law = contact_law(made, response.harmonics, None, response.friction, constant_load)
    w = law(u[None]).w[0]
    given = u - to_real(response.force[point, :, contact]) / stiffness.T
    largest = np.abs(response.contact[point]).max()
    # without coupling the mean force is that at rest, not the mean over the period
    first = 0 if response.coupling == "coupled" else 1
    gap = np.abs(w - given)[:, first:].max(initial=0.0)
    apart = float(gap / largest) if largest > 0 else 0.0
    if apart > _AGREEMENT:
        raise InputError(
            f"response: contact {contact} has forces {apart:.1e} away from the contact law: a "
            f"loop needs a nonlinear response without plain samples and its own mu, within "
            f"{_AGREEMENT:g}"
        )


def _slider_history(v: Floats, u: Floats, alpha: float, angle: Floats) -> Floats:
    """Place of a friction slider at the given angles in [0, 2π)."""
    harmonics = (len(u) - 1) // 2
    table, contact = grid(harmonics), np.empty(4 * harmonics + 4)
    path = np.empty((6 * len(contact) + 2, WIDTH))
    v, u = np.ascontiguousarray(v), np.ascontiguousarray(u)
    count = roots(v, table, contact)
    path = path[: slider_path(v, u, alpha, contact, count, table, path)]
    wrapped = path[0, BEGIN] + (angle - path[0, BEGIN]) % TURN
    segment = np.searchsorted(path[:, BEGIN], wrapped, side="right") - 1
    kind = path[segment, KIND]
    at_v, at_u = (basis(harmonics, angle) @ a for a in (v, u))
    bound = np.select([kind == LOW, kind == HIGH, kind == FREE], [-alpha, alpha, 0.0])
    return np.where(kind == HELD, path[segment, PLACE], at_u + bound * at_v)
