"""Arguments of the kind that is annotated pass; another kind is a line that names them."""

import inspect
import pickle
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Literal

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from vanelock import fem, mesh, nonlinear, rom
from vanelock.common.arguments import of_kind
from vanelock.common.errors import InputError
from vanelock.nonlinear import Contact, Options, System


@of_kind
def called(
    count: int = 1,
    ratio: float | None = None,
    values: ArrayLike | tuple[float, float] = (1.0, 2.0),
    mask: NDArray[np.bool_] | None = None,
    joints: str | Sequence[str] = "all",
    orders: Iterable[int] = (),
    way: Literal["up", "down"] = "up",
    factors: Mapping[int, complex] | None = None,
    pair: tuple[str, int] = ("a", 1),
    contacts: Sequence[Contact] = (),
    progress: Callable[[int], None] | None = None,
) -> str:
    return f"called{sum(orders)}"


CONTACT = Contact(tangential=0, mu=0.3, kt=1.0, preload=1.0)


@pytest.mark.parametrize(
    ("name", "right", "wrong", "line"),
    [
        ("count", [1, np.int64(1), np.array(1)], 1.5, "given 1.5: needs a whole number"),
        ("count", [], True, "given True: needs a whole number"),
        ("ratio", [None, 1, np.float64(1)], "a", "given 'a': needs a number or None"),
        (
            "values",
            [5, [], [1, 2], (1, 2), np.eye(2), sparse.eye(2)],
            ["a"],
            "given ['a']: needs an array of numbers or (a number, a number)",
        ),
        ("mask", [None, np.array([True])], [], "given []: needs a NumPy array or None"),
        ("joints", ["a", ["a"], ()], ["a", 1], "joints[1]: given 1: needs text"),
        ("orders", [{0}, np.arange(1), []], [0, 0.5], "orders[1]: given 0.5: needs a whole number"),
        ("way", ["down"], [], "given []: needs 'up' or 'down'"),
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
def test_kinds(name, right, wrong, line):
    assert {called(**{name: value}) for value in right} <= {"called0"}
    with pytest.raises(InputError) as caught:
        called(**{name: wrong})
    assert str(caught.value).startswith(name)
    assert line in str(caught.value)


def test_what_can_be_read_but_once_is_left_to_the_function():
    assert called(orders=iter([1, 2])) == "called3"


@pytest.mark.parametrize("package", [mesh, fem, rom, nonlinear], ids=lambda each: each.__name__)
def test_every_public_function_names_what_is_of_another_kind(package):
    """What a package hands out is the function of the module, checked, also in other processes."""
    offered = {name: getattr(package, name) for name in package.__all__}
    functions = {name: each for name, each in offered.items() if inspect.isfunction(each)}
    assert len(functions) > 5
    for name, function in functions.items():
        assert pickle.loads(pickle.dumps(function)) is function
        inner = inspect.unwrap(function)
        assert (function.__name__, function.__doc__) == (name, inner.__doc__)
        assert inspect.signature(function) == inspect.signature(inner)
        for first in list(inspect.signature(function).parameters)[:1]:
            with pytest.raises(InputError, match=rf"\A{first}: given .*: needs .*\Z"):
                function(object())


def test_what_systems_are_made_of_names_what_is_of_another_kind():
    M, K = 0.1 * np.eye(2), np.array([[1e4, -1e4], [-1e4, 1e4]])
    for make, line in (
        (lambda: Options(tolerance="a"), "Options.tolerance: given 'a': needs a number"),
        (lambda: rom.united(5), "systems: given 5: needs a list"),
        (lambda: mesh.VaneDimensions(chord="a"), 'chord = "a": expected .*number in m'),
        (lambda: nonlinear.Mistuning.scatter(5, {}), "system: given 5: needs a System"),
        (lambda: System.from_matrices(M, K, CONTACT), "contacts: given a Contact: needs a list"),
        (lambda: System.from_matrices(M, K, outputs=["a"]), "outputs: given .*: needs a dict or N"),
        (lambda: System.from_matrices(K, M), "M: not positive: .*; K is: are they exchanged?"),
    ):
        with pytest.raises(InputError, match=line):
            make()
