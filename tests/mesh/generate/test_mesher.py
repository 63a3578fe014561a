"""Which of several meshes is kept."""

import pytest

from vanelock.mesh import VaneDimensions, vane_segment
from vanelock.mesh.generate import mesher


@pytest.mark.parametrize(
    ("qualities", "sizes"),
    [
        ([0.2], [1.0]),  # the size asked for, where it serves
        ([0.01, 0.2], [1.0, 0.95]),
        ([-1.0, 0.0, 0.021], [1.0, 0.95, 0.9]),  # none at all, then an element without height
        ([0.01, 0.019, 0.0, 0.01], [1.0, 0.95, 0.9, 0.85, 0.95]),  # the best again
        ([0.01, 0.01, 0.01, 0.015], [1.0, 0.95, 0.9, 0.85]),  # it is there already
    ],
)
def test_sizes_are_tried_until_one_serves(monkeypatch, qualities, sizes):
    tried = []

    def attempt(gmsh, size, local, finer):
        tried.append(size * finer)
        quality = qualities[(len(tried) - 1) % len(qualities)]
        if quality < 0:
            raise Exception("no mesh")  # as gmsh does
        return quality

    monkeypatch.setattr(mesher, "_attempt", attempt)
    mesher.tetrahedra(None, 1.0)
    assert tried == sizes


def test_what_cannot_be_meshed_at_any_size_says_why(monkeypatch):
    def attempt(gmsh, size, local, finer):
        raise Exception(f"no mesh at {finer * size}")

    monkeypatch.setattr(mesher, "_attempt", attempt)
    with pytest.raises(Exception, match="no mesh at 1.0"):
        mesher.tetrahedra(None, 1.0)


def test_a_vane_is_meshed_once(monkeypatch):
    """The elements that span its rounded edges are sound, though two sides lie on one face."""
    sizes = []
    attempt = mesher._attempt

    def counted(gmsh, size, local, finer):
        sizes.append(finer * size)
        return attempt(gmsh, size, local, finer)

    monkeypatch.setattr(mesher, "_attempt", counted)
    vane_segment(VaneDimensions(aerofoils=1), size=0.025)
    assert sizes == [0.025]
