"""Contact rows against rigid motions of the whole ring, which open and slide nothing."""

import numpy as np
import pytest


def ring_motion(points, kind, sectors):
    """Sector 0's coefficients of a rigid motion of the ring, and its nodal diameter.

    A translation along the fixed direction e_x - i e_y, seen by sector j in its own frame (turned
    by 2πj/N), is sector 0's times e^{-2πij/N}: nodal diameter 1.
    """
    u = np.zeros((len(points), 3), complex)
    if kind == "axial translation":
        u[:, 2] = 1.0
        return u, 0
    if kind == "turn about the axis":
        u[:, 0], u[:, 1] = -points[:, 1], points[:, 0]
        return u, 0
    turning = np.array([1.0, -1.0j, 0.0])
    for j in (1, 2):  # the claim above, by rotating the direction into sector j's frame
        a = 2 * np.pi * j / sectors
        back = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])
        np.testing.assert_allclose(back @ turning, turning * np.exp(-1j * a), atol=1e-14)
    if kind == "lateral translation":
        return u + turning, 1
    tilt = np.cross(turning, points)
    return u + tilt, 1


@pytest.mark.parametrize(
    "kind", ["axial translation", "turn about the axis", "lateral translation", "tilt"]
)
def test_rigid_motion_of_the_ring_moves_no_contact(masters_alone, kind):
    vane, casing, system = masters_alone.vane, masters_alone.casing, masters_alone.system
    x_vane, k = ring_motion(vane.masters.points, kind, system.sectors)
    x_casing, _ = ring_motion(casing.masters.points, kind, system.sectors)
    x = np.zeros(len(system.at(k).K), complex)
    joined = masters_alone.joined_dofs
    x[joined[vane.dofs(vane.masters.nodes).ravel()]] = x_vane.ravel()
    x[casing.dofs(casing.masters.nodes).ravel()] = x_casing.ravel()
    relative = system.contact_rows(k) @ x
    assert np.abs(relative).max() < 1e-12 * np.abs(x).max()
    # ... but the next sector's rows matter: without them the interlock would seem to slide.
    interlock = np.array([name == "interlock" for name in system.contacts.joint])
    assert np.abs(system.at(k).own[interlock] @ x).max() > 0.1 * np.abs(x).max()


def test_vane_moved_towards_its_mates_closes_the_contacts(masters_alone):
    """A pure outward motion of the vane closes the roof bands and opens the lip bands."""
    vane, system = masters_alone.vane, masters_alone.system
    points = vane.masters.points
    radial = points * [1, 1, 0] / np.hypot(points[:, 0], points[:, 1])[:, None]
    x = np.zeros(len(system.at(0).K))
    x[masters_alone.joined_dofs[vane.dofs(vane.masters.nodes)]] = radial
    hook = np.array([name == "hook" for name in system.contacts.joint])
    v = (system.contact_rows(0) @ x)[hook, 0]
    np.testing.assert_allclose(v, np.tile(np.repeat([1.0, -1.0], 14), 2), atol=1e-12)


def test_neighbours_pressed_together_close_the_interlock(masters_alone):
    """A vane whose right face alone moves towards the neighbour gains its normal component."""
    vane, system = masters_alone.vane, masters_alone.system
    right = vane.masters.node_sets["interlock_right"]
    frames = vane.masters.frames["interlock_right"]
    x = np.zeros(len(system.at(0).K))
    x[masters_alone.joined_dofs[vane.dofs(right)]] = frames[:, 0]
    interlock = np.array([name == "interlock" for name in system.contacts.joint])
    relative = (system.contact_rows(0) @ x)[interlock]
    np.testing.assert_allclose(relative, np.tile([1.0, 0.0, 0.0], (10, 1)), atol=1e-12)
