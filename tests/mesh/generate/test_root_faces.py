"""Vanes whose aerofoils have fillets: closed, sound, as large as they should be."""

import numpy as np
import pytest

from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh import VaneDimensions, quality, vane_segment
from vanelock.mesh.generate.aerofoils import arc_rows, divide_filleted, divisions
from vanelock.mesh.generate.vane import _vane_solid
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.root_fillet import feet, strips
from vanelock.mesh.gmsh_session import session

SLANTED = {"interlock_slant": -30.0, "stagger": -30.0, "lean": 4.0}


def test_meshes_are_sound_and_fill_the_geometry() -> None:
    turned = {"camber": 0.2, "twist": 15.0, **SLANTED}
    part = vane_segment(VaneDimensions(root_fillet=0.004, aerofoils=1, **turned), 16, 0.025)
    found = quality(part)
    assert found.smallest_jacobian > 0.05
    assert found.smallest_sicn > 0.02
    assert part.cad_volume is not None
    assert found.volume == pytest.approx(part.cad_volume, rel=5e-4)


def test_fillets_add_what_their_volume_says() -> None:
    """The sharp one's figure is the kernel's, the other one integrated by ourselves."""
    plain, rounded = (
        vane_segment(VaneDimensions(aerofoils=1, root_fillet=radius), size="coarse")
        for radius in (0, 0.003)
    )
    added = quality(rounded).volume - quality(plain).volume
    # (1 - π/4) r² of two roots 98 mm long, a little less for the slant, more around edges.
    assert added == pytest.approx(2 * 0.098 * 0.2146 * 9e-6, rel=0.06)
    assert plain.cad_volume is not None
    assert rounded.cad_volume - plain.cad_volume == pytest.approx(added, rel=0.02)


def test_a_node_stands_in_every_row_of_a_mitre() -> None:
    vane = VaneDimensions(aerofoils=1, root_fillet=0.003, lean=5.0, twist=6.0)
    part = vane_segment(vane, size="coarse")
    corners = part.points[np.unique(part.cells[:, :4])] - [0, 0, vane.hook.mid_plane]
    rows = divisions(vane, 0.03).rows
    assert arc_rows(vane) == 3
    for angle in aerofoil.angles(vane, 16):
        turned = corners @ rotation(angle)
        for outer in (False, True):
            for strip, foot in zip(strips(vane, outer), feet(vane, outer), strict=True):
                arc = strip.arc(0, np.linspace(0, 1, 2001))
                off = np.linalg.norm(turned[:, None] - arc[None, ::20], axis=2).min(axis=1)
                near = turned[off < 1e-4]
                exact = np.linalg.norm(near[:, None] - arc[None], axis=2).min(axis=1)
                assert np.sum(exact < 2e-6) == 4
                assert np.linalg.norm(turned - foot, axis=1).min() < 1e-6
        side = aerofoil.outline(vane, np.array([-1.0]))[0, 0]
        line = turned[np.abs(turned[:, 2] - side[1]) < 2e-3]
        assert len(line) >= rows - 1


def test_faces_that_are_missing_are_reported() -> None:
    expected = r"^vane\.root_fillet = 0\.003 m: \d+ faces between the shrouds instead of 96"
    vane = VaneDimensions(root_fillet=0.003)
    with session("vane") as gmsh:
        _vane_solid(gmsh, VaneDimensions(), 16)
        gmsh.model.occ.synchronize()
        with pytest.raises(InputError, match=expected):
            divide_filleted(gmsh, vane, 16, 0.025)
