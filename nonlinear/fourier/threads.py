"""How many threads the dense algebra of a point uses: one."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from threadpoolctl import threadpool_limits

Function = TypeVar("Function", bound=Callable[..., Any])


def one_thread(function: Function) -> Function:
    """Hold BLAS to one thread while `function` runs.

    The matrices of a point are too small for several: two threads save nothing on an idle machine,
    and cost a factor of thirty where other work keeps one of them waiting for its core.
    """
    return cast(Function, threadpool_limits.wrap(limits=1, user_api="blas")(function))
