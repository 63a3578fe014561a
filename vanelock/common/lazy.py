"""Names of a package, and optional libraries, that are imported when they are first used.

`import vanelock.nonlinear` must load neither gmsh nor scikit-fem nor VTK, and each stage's
package offers names from modules that need them. Every stage's `__init__` therefore lists its
names and where they live, and imports a module only when one of its names is asked for (PEP 562).
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from vanelock.common.errors import InputError


def attributes(
    package: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose names live in modules imported on demand.

    Parameters
    ----------
    package : str
        Full name of the package, `__name__` there.
    modules : mapping of str to str
        Public name to the module inside the package that defines it, or, after a dot, in the
        package above. No name may be a module's or a room's: importing one binds it to that name
        in its package and would hide the attribute.
    """
    if clash := set(modules) & {path.split(".")[0] for path in modules.values()}:
        raise ImportError(f"{package}: {sorted(clash)} name both a module and an attribute")

    def __getattr__(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f".{modules[name]}", package), name)

    def __dir__() -> list[str]:
        return sorted(modules)

    return __getattr__, __dir__


def library(name: str, extra: str, who: str, called: str = "") -> Any:
    """An optional library.

    Parameters
    ----------
    name : str
        Of its module.
    extra : str
        Of ours that brings it.
    who : str
        What needs it, in messages.
    called : str
        What people call it, where that is not the module's name.

    Raises
    ------
    InputError
        If it is not installed: one line with the command that installs it.
    """
    try:
        return import_module(name)
    except ImportError:
        needed = called or name
        raise InputError(f"{who}: needs {needed}: pip install 'vanelock[{extra}]'") from None
