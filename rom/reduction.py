"""From a finite-element model to a component, by one of two routes, or of a part in one piece.

    { x_m }   [ I  0 ] { x_m }
    { x_s } = [ Ψ  B ] { η   },      Ψ = -K_ss⁻¹ K_sm,    B: fixed-interface modes and more,

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319; which vectors B holds is documented in `vanelock.rom.fixed_interface.selection`.
"""

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np

from vanelock.common.errors import InputError
from vanelock.fem import Model
from vanelock.rom.component import Component, Masters, choose
from vanelock.rom.fixed_interface.selection import DEFAULT, Selection
from vanelock.rom.routes.condensed import Condensed, Loads, condensed, reduced
from vanelock.rom.routes.problem import Problem, problem
from vanelock.rom.routes.tran import CraigBampton, craig_bampton, paper

_Route = Literal["cyclic", "paper"]
_MODES = 10  # default number of fixed-interface and of face modes of the route "paper"


def reduce(
    model: Model,
    masters: Sequence[str],
    modes: int | None = None,
    nodal_diameters: Iterable[int] | None = None,
    route: _Route = "cyclic",
    interface_modes: int | None = None,
    *,
    cutoff: float | None = None,
    accuracy: float | None = None,
    band: float | None = None,
    least: float | None = None,
    averaged: Sequence[str] = (),
    prepared: Condensed | CraigBampton | None = None,
    loads: Loads | None = None,
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
    route : {"cyclic", "paper"}
        For a cyclic part. "cyclic": cyclic symmetry first, then Craig-Bampton; the most accurate
        for its size. "paper": Craig-Bampton with every dof of the cyclic faces `left` and `right`
        a master, then cyclic symmetry, then Tran's reduction of the faces, as published.
    interface_modes : int, optional
        Face modes that the route "paper" keeps, at most the face's dofs; by default ten.
    cutoff : float, optional
        Instead of `modes`: all fixed-interface modes up to this frequency, Hz.
    accuracy : float, optional
        Instead of `modes`: what it takes for every natural frequency in the band, whatever the part
        is joined to, to be within this relative error; see `fixed_interface.selection`. 1e-4 where
        nothing else is given and the route allows it.
    band : float, optional
        Frequency up to which the accuracy holds, Hz; by default that of the part's tenth elastic
        mode with its masters free.
    least : float, optional
        Frequency that the band reaches at least where it is not given, Hz.
    averaged : sequence of str
        Contact sets whose nodes stand for their patches: the masters' displacements are the means
        over them, and a key node of such a set is tied by its mean; see `rom.joining.patches`.
        The other part's set must be averaged too.
    prepared : optional
        What `prepare` made of this model, these masters and this route: nodal diameters that are
        reduced one after the other, and the recovery of fields, need not compute it again.
    loads : dict of str to (n,) float, optional
        Loads at rest by name on the model's free dofs, N, as `fem.pressure`, `fem.thermal` and
        `fem.centrifugal` give them: the static answer to each is a further vector at nodal diameter
        0, at which they act. Not by the route "paper".

    Raises
    ------
    InputError
        If a set is missing or clamped, a value is out of range, or the part can move although its
        masters are held.
    """
    cyclic = nodal_diameters is not None
    _check_route(route, interface_modes, accuracy, cyclic)
    diameters = _diameters(nodal_diameters, model.part.sectors)
    chosen = choose(model.part, tuple(masters), tuple(averaged))
    if modes is None and cutoff is None and accuracy is None:
        if cyclic and route != "cyclic":
            modes = _MODES
        else:
            accuracy = DEFAULT
    wanted = Selection(modes, cutoff, accuracy, band, least)
    if prepared is None:
        given = problem(model, chosen, cyclic)
    else:
        given = _same(prepared, model, chosen, cyclic, route, wanted)
    _check_loads(loads, cyclic, route, diameters)
    if route == "paper":
        count, faces = interface_modes or _MODES, 3 * len(given.left)
        if count > faces:
            raise InputError(
                f"interface_modes = {count}: allowed are 1 to {faces}, the dofs of a face"
            )
        dense = prepared if isinstance(prepared, CraigBampton) else craig_bampton(given, wanted)
        return paper(dense, diameters, count)
    shared = prepared if isinstance(prepared, Condensed) else condensed(given)
    return reduced(shared, wanted, diameters, loads)


def prepare(
    model: Model,
    masters: Sequence[str],
    averaged: Sequence[str] = (),
    cyclic: bool = True,
    route: _Route = "cyclic",
    modes: int | None = None,
) -> Condensed | CraigBampton:
    """What the reductions of a part at all nodal diameters share: factors, for its recovery, too.

    By the route "paper" its Craig-Bampton model with every dof of the faces a master.

    Parameters
    ----------
    model, masters, averaged, route, modes
        As for `reduce`.
    cyclic : bool
        Whether it is to be reduced at nodal diameters, not in one piece.
    """
    given = problem(model, choose(model.part, tuple(masters), tuple(averaged)), cyclic)
    if route == "paper":
        return craig_bampton(given, Selection(modes=modes or _MODES))
    return condensed(given)


def _same(
    prepared: Condensed | CraigBampton,
    model: Model,
    chosen: Masters,
    cyclic: bool,
    route: str,
    selection: Selection,
) -> Problem:
    """The problem that was prepared, which must be the one that is asked for."""
    found = prepared.problem
    own, given = found.masters, (chosen.nodes, chosen.averaged)
    if isinstance(prepared, CraigBampton) != (route == "paper"):
        raise InputError(f'prepared: by another route than "{route}"')
    if isinstance(prepared, CraigBampton) and prepared.fixed_modes.shape[1] != selection.modes:
        have = prepared.fixed_modes.shape[1]
        raise InputError(f"prepared: with {have} fixed-interface modes: give as many as modes")
    same = all(np.array_equal(*each) for each in zip((own.nodes, own.averaged), given, strict=True))
    if found.cyclic != cyclic or not same or found.model is not model:
        raise InputError(
            f"prepared: it is of {found.model.part.name} with the masters "
            f"{', '.join(found.masters.node_sets)}: give the same model, masters and averaged sets"
        )
    return found


def _check_route(
    route: str, interface_modes: int | None, accuracy: float | None, cyclic: bool
) -> None:
    """Refuse what a route does not know, rather than leave it unheeded."""
    if route != "cyclic" and not cyclic:
        raise InputError(f'route = "{route}": a part in one piece has none: give nodal_diameters')
    if interface_modes is not None and interface_modes < 1:
        raise InputError(f"interface_modes = {interface_modes}: allowed are 1 and more")
    if interface_modes is not None and route == "cyclic":
        what = 'the route "cyclic"' if cyclic else "a part in one piece"
        raise InputError(
            f"interface_modes = {interface_modes}: {what} has no interface to reduce: "
            'they go with route = "paper"'
        )
    if cyclic and route != "cyclic" and accuracy is not None:
        raise InputError(
            f'accuracy = {accuracy}: the route "{route}" takes modes or cutoff; '
            'accuracy needs route = "cyclic"'
        )


def _check_loads(loads: Loads | None, cyclic: bool, route: str, diameters: Sequence[int]) -> None:
    """Refuse loads at rest that a reduction cannot answer."""
    if not loads or not cyclic:
        return
    name = next(iter(loads))
    if route != "cyclic":
        raise InputError(
            f'loads[{name!r}]: the route "{route}" keeps no static answers: choose route = "cyclic"'
        )
    if 0 not in diameters:
        given = ", ".join(map(str, diameters))
        raise InputError(f"loads[{name!r}]: act at nodal diameter 0, not at {given}")


def _diameters(nodal_diameters: Iterable[int] | None, sectors: int) -> list[int]:
    """Nodal diameters 0 to N - 1, ascending, each once; 0 for a part in one piece."""
    if nodal_diameters is None:
        return [0]
    if not (found := {int(k) % sectors for k in nodal_diameters}):
        raise InputError("nodal_diameters: given none: needs one or several whole numbers")
    return sorted(found)
