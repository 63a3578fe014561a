"""A point may take so many Newton steps; what is then not found is looked for from behind."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.nonlinear import Contact, Element, Options, System, frequency_response
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation import globalisation
from vanelock.nonlinear.continuation.globalisation import Effort, from_nothing
from vanelock.nonlinear.forced_response import frequency_sweep
from vanelock.nonlinear.newton.newton import solve

HERTZ = np.linspace(0.5, 2.5, 41) / (2 * np.pi)


def folding() -> System:
    """A mass on a spring that hardens: two solutions between two folds, and one between them."""
    spring = Element(force="cubic_spring", places=[0], parameters=[4.0])
    return System.from_matrices([[1.0]], [[1.0]], elements=[spring], C=[[0.02]], force={0: 0.1})


def test_what_a_sweep_loses_is_found_from_the_other_side(monkeypatch: Any) -> None:
    options, heard = Options(3, direction="down"), []
    whole = frequency_response(folding(), HERTZ, options, find_jumps=False)
    asked: list[float] = []

    def once(balance: Any, *more: Any) -> Any:
        asked.append(balance.omega)
        found = from_nothing(balance, *more)
        return found if len(asked) == 1 else replace(found, converged=False, residual=1.0)

    monkeypatch.setattr(frequency_sweep, "from_nothing", once)

    def progress(done: int, total: int, hertz: float, amplitude: float) -> None:
        if np.isnan(amplitude):
            heard.append(hertz)

    found = frequency_response(folding(), HERTZ, options, progress, find_jumps=False)
    assert len(asked) > 2  # the first one, and what lies below the fold
    assert found.converged.all()
    np.testing.assert_allclose(found.amplitude, whole.amplitude, rtol=1e-9)
    assert set(np.round(heard, 9)) >= set(np.round(np.array(asked[1:]) / (2 * np.pi), 9))


@pytest.mark.parametrize("most", [40, 400])
def test_ways_to_a_solution_end_with_their_steps(monkeypatch: Any, most: int) -> None:
    contact = Contact(tangential=0, normal=0, kt=1.0, kn=1.0, mu=0.3, preload=0.1)
    system = System.from_matrices([[1.0]], [[1.0]], [contact], C=[[0.02]], force={0: 0.1})
    balance = structure(system, 1).balance(1.0)
    spent: list[int] = []

    def never(*given: Any, **more: Any) -> Any:
        found = solve(*given, **more)
        spent.append(found.iterations)
        return replace(found, converged=False)

    monkeypatch.setattr(globalisation, "solve", never)
    attempts: list[int] = []
    effort = Effort(most, lambda: attempts.append(effort.left))
    found = from_nothing(balance, lambda h: contact_law(system.contacts, h), 1e-10, effort)
    assert not found.converged
    assert attempts
    assert all(left > 0 for left in attempts)
    assert effort.left == most - sum(spent)


def test_no_effort_is_refused() -> None:
    with pytest.raises(InputError, match="effort: given 0: must be >= 1"):
        Options(effort=0)
