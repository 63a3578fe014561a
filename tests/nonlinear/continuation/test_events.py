"""Where a quantity passes zero along a path, and where the path jumps instead."""

import math
from itertools import islice

import numpy as np
import pytest

from tests.nonlinear.following.test_peak import jenkins
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation import arc_length
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.continuation.path import SolutionPath
from vanelock.nonlinear.newton.newton import solve


@pytest.mark.parametrize(("jump", "kink"), [(0.0, False), (0.0, True), (1.0, True)])
def test_a_quantity_that_jumps_is_located_unless_the_path_jumps(monkeypatch, jump, kink):
    system = jenkins(force=3.0)
    family = Frequencies(structure(system, 1), contact_law(system.contacts, 1))
    begun = solve(family, np.zeros((1, 3, 3)), 0.9)
    before, after = islice(SolutionPath(family, begun, 1.2), 2)
    first, last = before.solution.parameter, after.solution.parameter
    middle = 0.3 * first + 0.7 * last

    def moved(*given, **options):
        found = solve(*given, **options)
        aside = jump * np.ptp([before.solution.w, after.solution.w], axis=0)
        vars(found)["w"] = found.w + (aside if found.parameter > middle else 0.0)
        return found

    def quantity(solution, tangent=None):
        left = middle - solution.parameter
        return math.copysign(1.0, left) if kink else float(left)

    monkeypatch.setattr(arc_length, "solve", moved)
    ends = (quantity(before.solution), quantity(after.solution))
    found = arc_length.locate(family, before, after, quantity, ends)
    if jump:
        assert found is None
    else:
        assert found is not None
        assert found.solution.parameter == pytest.approx(middle, rel=1e-10)
