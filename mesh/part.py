"""The product of the mesh stage: nodes, elements and named node sets of one part."""

from collections.abc import Collection
from dataclasses import dataclass, field

import scipy.sparse as sp

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product


@dataclass(frozen=True)
class Part(Product):
    """A meshed part, one sector of a cyclic structure or a whole one, in metres.

    The engine axis is z; sector j+1 is sector j turned by +2π/N about it. Two parts of one study
    share this coordinate system. The sets that the later stages know by name:

    - `fixed`: clamped nodes;
    - `left`, `right`: cyclic faces, `right[i]` being `left[i]` turned by 2π/N;
    - `hook_front`, `hook_rear`: contact nodes, in the same order on the vane and on the casing,
      the band on the groove's roof first, each band by ascending angle;
    - `key`: nodes merged with the other part's nodes of that set, in the same order, which also
      belong to the hook bands but carry no contact element;
    - `interlock_left`, `interlock_right`: `interlock_right[i]` of one sector meets
      `interlock_left[i]` of the next;
    - `force`: loaded nodes; `output`: output nodes.

    Attributes
    ----------
    name : str
        What errors and files call it, "vane" or "casing".
    points : (n, 3) float
        Node coordinates, m. Every node belongs to an element.
    cells : (e, k) int
        Nodes of each element, in meshio's order for `cell_type`.
    cell_type : str
        meshio's name of the element type, such as "tetra10".
    node_sets : dict of str to (k,) int
        Node numbers of each set.
    frames : dict of str to (k, 3, 3) float
        Contact frame at each node of a contact set: rows are the unit outward normal of this
        part and two tangents, in Cartesian components. At the hooks: radial, circumferential,
        axial. At the interlock: face normal, radial, and the in-plane direction across it.
        The frame of `interlock_right[i]` is that of `interlock_left[i]` with the normal and the
        second tangent reversed, turned by 2π/N.
    sectors : int
        Number of sectors N in the ring; 1 if the part is whole.
    patches : dict of str to (k, n) csc_array
        Of some contact sets: row i holds the weights of all nodes in the mean displacement over
        the contact patch of node i. The weights sum to one, and their mean place is the patch's
        centroid, which both parts of a joint share. Empty where a joint acts on nodes only.
    areas : dict of str to (k,) float
        Of contact sets that consist of whole faces: the area that belongs to each node, m².
    cad_volume : float or None
        Volume of the geometry that was meshed, m³, where there was one.
    """

    name: str
    points: Floats = field(metadata={"unit": "m"})
    cells: Integers
    cell_type: str
    node_sets: dict[str, Integers]
    frames: dict[str, Floats]
    sectors: int
    patches: dict[str, sp.csc_array] = field(default_factory=dict)
    areas: dict[str, Floats] = field(default_factory=dict, metadata={"unit": "m^2"})
    cad_volume: float | None = field(default=None, metadata={"unit": "m^3"})

    def nodes(self, node_set: str) -> Integers:
        """(k,) nodes of a set; case counts only where two names differ by nothing else.

        Raises
        ------
        InputError
            If the part has no such set.
        """
        if (own := called(self.node_sets, node_set)) is None:
            have = ", ".join(sorted(self.node_sets)) or "none"
            raise InputError(f"{self.name}: no node set {node_set!r}; it has {have}")
        return self.node_sets[own]


def called(names: Collection[str], spelling: str) -> str | None:
    """The name itself, or the only one that differs from it in case: decks have capitals alone."""
    if spelling in names:
        return spelling
    alike = [name for name in names if name.casefold() == spelling.casefold()]
    return alike[0] if len(alike) == 1 else None
