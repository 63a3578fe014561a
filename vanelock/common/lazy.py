"""Names of a package, and optional libraries, that are imported when they are first used.

`import vanelock.nonlinear` must load neither gmsh nor scikit-fem nor VTK, and each stage's
package offers names from modules that need them. Every stage's `__init__` therefore lists its
names and where they live, and imports a module only when one of its names is asked for (PEP 562).
"""

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from types import FunctionType
from typing import Any

from vanelock.common.errors import InputError


def attributes(
    package: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose names live in modules imported on demand.

    `modules` are those inside the package that define its public names, or, after a dot, in the
    package above. No name may be a module's or a room's: importing one binds it to that name in
    its package and would hide the attribute. A function's arguments are held against its
    annotations before it is called: see `arguments.of_kind`.
    """
    if clash := set(modules) & {path.split(".")[0] for path in modules.values()}:
        raise ImportError(f"{package}: {sorted(clash)} name both a module and an attribute")

    def __getattr__(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f".{modules[name]}", package), name)
        return _checked(value, package) if isinstance(value, FunctionType) else value

    def __dir__() -> list[str]:
        return sorted(modules)

    return __getattr__, __dir__


@cache
def _checked(function: FunctionType, package: str) -> Callable[..., Any]:
    """A function as a package hands it out, where another process finds it by its name, too."""
    from vanelock.common.arguments import of_kind

    called = of_kind(function)
    called.__module__ = package
    return called


def library(name: str, extra: str, who: str, called: str = "") -> Any:
    """An optional library, or one line with the `extra` of ours that brings it to `who` needs it.

    `called` is what people call it, where that is not the module's name.
    """
    try:
        return import_module(name)
    except ImportError:
        needed = called or name
        raise InputError(f"{who}: needs {needed}: pip install 'vanelock[{extra}]'") from None
