"""Arguments of the kind that is annotated pass; another kind is a line that names them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy import sparse

from vanelock import nonlinear, rom
from vanelock.common.errors import InputError
from vanelock.nonlinear import Contact, Options, System
from vanelock.rom.system.arguments import of_kind


@of_kind
def called(
    count: int = 1,
    ratio: float | None = None,
    values: ArrayLike | tuple[float, float] = (1.0, 2.0),
    joints: str | Sequence[str] = "all",
    factors: Mapping[int, complex] | None = None,
    pair: tuple[str, int] = ("a", 1),
    contacts: Sequence[Contact] = (),
    progress: Callable[[int], None] | None = None,
) -> str:
    return "called"


CONTACT = Contact(tangential=0, mu=0.3, kt=1.0, preload=1.0)


@pytest.mark.parametrize(
    ("name", "right", "wrong", "line"),
    [
        ("count", [1, np.int64(1), np.array(1)], 1.5, "given 1.5: needs a whole number"),
        ("ratio", [None, 1, np.float64(1)], "a", "given 'a': needs a number or None"),
        (
            "values",
            [5, [], [1, 2], (1, 2), np.eye(2), sparse.eye(2)],
            ["a"],
            "given ['a']: needs an array of numbers or (a number, a number)",
        ),
        ("joints", ["a", ["a"], ()], ["a", 1], "joints[1]: given 1: needs text"),
        ("factors", [{1: 1j}, None], [1], "given [1]: needs a dict or None"),
        (
            "pair",
            [("a", 0), ["a", 0]],
            ("a", "b"),
            "given ('a', 'b'): needs (text, a whole number)",
        ),
        ("contacts", [[CONTACT], ()], CONTACT, "needs a list, each a Contact"),
        ("progress", [print, None], 5, "given 5: needs a function or None"),
    ],
)
def test_kinds(name: str, right: list[Any], wrong: Any, line: str) -> None:
    assert {called(**{name: value}) for value in right} == {"called"}
    with pytest.raises(InputError) as caught:
        called(**{name: wrong})
    assert str(caught.value).startswith(name)
    assert line in str(caught.value)


def test_slips_at_the_doors_of_the_solver_are_named() -> None:
    M, K = 0.1 * np.eye(2), np.array([[1e4, -1e4], [-1e4, 1e4]])
    system = System.from_matrices(M, K, [CONTACT], force={1: 1.0})
    for door, line in (
        (lambda: nonlinear.frequency_response(system, [1.0], options=5), "options: given 5: needs"),
        (lambda: nonlinear.static_response(system, None), "options: given None: needs an Options"),
        (lambda: nonlinear.stability(system, 5), "response: given 5: needs a Response"),
        (lambda: rom.linear_modes(system, 0, "a"), "count: given 'a': needs a whole number"),
        (lambda: rom.join(5, 5, [], 5), "vane: given 5: needs a Component"),
        (lambda: Options(tolerance="a"), "tolerance: given 'a': needs a number"),
        (lambda: System.from_matrices(M, K, CONTACT), "contacts: given a Contact: needs a list"),
        (lambda: System.from_matrices(M, K, outputs=["a"]), "outputs: given .*: needs a dict or N"),
        (lambda: System.from_matrices(K, M), "M: not positive: .*; K is: are they exchanged?"),
    ):
        with pytest.raises(InputError, match=line):
            door()
