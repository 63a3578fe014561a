"""From a finite-element model to a component, by one of three routes."""

from collections.abc import Iterable, Sequence
from typing import Literal

from vanelock.errors import InputError
from vanelock.fem import Model
from vanelock.rom.component import Component
from vanelock.rom.cyclic_first import cyclic_first
from vanelock.rom.direct import direct
from vanelock.rom.masters import choose
from vanelock.rom.paper import paper
from vanelock.rom.problem import problem
from vanelock.rom.selection import DEFAULT, Selection
from vanelock.rom.tran import Interface
from vanelock.rom.whole import whole

Route = Literal["cyclic", "direct", "paper"]
MODES = 10
"""Fixed-interface and face modes of the routes "paper" and "direct" unless given."""


def reduce(
    model: Model,
    masters: Sequence[str],
    modes: int | None = None,
    nodal_diameters: Iterable[int] | None = None,
    route: Route = "cyclic",
    interface: Interface | None = None,
    interface_modes: int | None = None,
    *,
    cutoff: float | None = None,
    accuracy: float | None = None,
    band: float | None = None,
    averaged: Sequence[str] = (),
) -> Component:
    """Reduce one part to its master nodes and a few modes.

    Parameters
    ----------
    model : fem.Model
        Sparse stiffness and mass of the part.
    masters : sequence of str
        Node sets whose displacements are kept, in this order.
    modes : int, optional
        Fixed-interface modes kept, the lowest ones.
    nodal_diameters : iterable of int, optional
        Reduce a cyclic part at these diameters; None: the part is in one piece.
    route : {"cyclic", "direct", "paper"}
        For a cyclic part. "cyclic": cyclic symmetry first, then Craig-Bampton; the most accurate
        for its size. "paper": Craig-Bampton with every dof of the cyclic faces `left` and `right`
        a master, then cyclic symmetry, then Tran's reduction of the faces, as published. "direct":
        the same subspace as "paper" without forming the faces' columns.
    interface : {"published", "followed"}, optional
        Basis of the face in the routes "paper" and "direct", see `vanelock.rom.tran`; "published"
        unless given.
    interface_modes : int, optional
        Face modes kept there, at most the face's dofs; ten unless given.
    cutoff : float, optional
        Instead of `modes`: all fixed-interface modes up to this frequency, Hz.
    accuracy : float, optional
        Instead of `modes`: what it takes for every natural frequency in the band, whatever the part
        is joined to, to be within this relative error; see `vanelock.rom.fixed`. 1e-4 where
        nothing else is given and the route allows it.
    band : float, optional
        Frequency up to which the accuracy holds, Hz; up to the part's tenth elastic mode with its
        masters free unless given.
    averaged : sequence of str
        Contact sets whose nodes stand for their patches: the masters' displacements are the means
        over them, and a key node of such a set is tied by its mean; see `vanelock.rom.patches`.
        The other part's set must be averaged too.

    Raises
    ------
    InputError
        If a set is missing or clamped, a value is out of range, or the part can move although its
        masters are held.
    """
    cyclic = nodal_diameters is not None
    _check_route(route, interface, interface_modes, accuracy, cyclic)
    given = problem(model, choose(model.part, masters, averaged), cyclic)
    if modes is None and cutoff is None and accuracy is None:
        if cyclic and route != "cyclic":
            modes = MODES
        else:
            accuracy = DEFAULT
    wanted = Selection(modes, cutoff, accuracy, band)
    if nodal_diameters is None:
        return whole(given, wanted)
    diameters = sorted({k % model.part.sectors for k in nodal_diameters})
    if route == "cyclic":
        return cyclic_first(given, wanted, diameters)
    follow = {"paper": paper, "direct": direct}[route]
    return follow(given, wanted, diameters, interface or "published", interface_modes or MODES)


def _check_route(
    route: str,
    interface: str | None,
    interface_modes: int | None,
    accuracy: float | None,
    cyclic: bool,
) -> None:
    """Refuse what a route does not know, rather than leave it unheeded."""
    if route not in ("cyclic", "direct", "paper"):
        raise InputError(f'route = "{route}": allowed are "cyclic", "direct" and "paper"')
    if interface not in (None, "published", "followed"):
        raise InputError(f'interface = "{interface}": allowed are "published" and "followed"')
    if interface_modes is not None and interface_modes < 1:
        raise InputError(f"interface_modes = {interface_modes}: allowed are 1 and more")
    if cyclic and route == "cyclic":
        for name, value in (("interface", interface), ("interface_modes", interface_modes)):
            if value is not None:
                raise InputError(
                    f'{name} = {value}: the route "cyclic" has no interface to reduce: '
                    'choose route = "direct" or "paper"'
                )
    if cyclic and route != "cyclic" and accuracy is not None:
        raise InputError(
            f'accuracy = {accuracy:g}: the route "{route}" takes modes or cutoff; '
            'accuracy needs route = "cyclic"'
        )
