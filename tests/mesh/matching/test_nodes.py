"""Which node meets which: two that would share a mate."""

import numpy as np

from vanelock.mesh.matching.pairing import mates


def test_two_nodes_cannot_share_a_mate():
    own = np.array([[0.0, 0, 0], [0.001, 0, 0], [1, 0, 0]])
    other = np.array([[0.0, 0, 0], [1, 0, 0]])

    def mistakes(own, other):
        names = (lambda i: f"own {i}", lambda i: f"other {i}")
        return mates(own, other, 0.01, ("A", "B"), names)[1]

    assert mistakes(own, other) == ["A: own 0 and own 1 both meet other 0 of B"]
    assert mistakes(other, own) == ["B: other 1 lies where another one meets A"]
    assert mistakes(own[[0, 2]], other) == []
