"""How large meshes may be: what a run's process takes of memory, and what there is.

    bytes = max(LEAST, BASE + EACH * degrees of freedom)

the largest of what was measured over meshes of 37,000 to 442,000 degrees of freedom
(docs/benchmarks/process.md).
"""

import math
from collections.abc import Mapping

from vanelock.common import process
from vanelock.common.errors import InputError
from vanelock.input.schema.study import Study
from vanelock.mesh.element_size import Size, element_size
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.refinement import casing_dofs, vane_dofs

DOFS = 1_000_000
"""Largest meshes chosen, estimated degrees of freedom of both parts; a study may set a larger."""
LEAST, BASE, EACH = 1.5e9, 0.35e9, 24.5e3
"""Peak memory, bytes: of a run with pictures, of libraries, and of a degree of freedom's matrices,
factors and vectors."""
SHARE = 0.7
"""Of all memory, what choices may take: the system and other programs have the rest."""
COARSE = 30_000
"""Degrees of freedom of the example's coarse meshes."""


def unknowns(study: Study, size: Size, mesh_dofs: Mapping[str, int] | None = None) -> float:
    """Degrees of freedom of both parts, meshed with elements of a size."""
    vane, casing, N = study.vane, study.casing, study.ring.sectors
    count, hook = float(sum((mesh_dofs or {}).values())), HookDimensions()
    if isinstance(vane, VaneDimensions):
        count, hook = count + vane_dofs(vane, N, element_size(size, "vane")), vane.hook
    if isinstance(casing, CasingDimensions):
        count += casing_dofs(casing, hook, N, element_size(size, "casing"), study.stretch)
    return count


def peak_memory(dofs: float) -> float:
    """Largest memory of a run's process, bytes."""
    return max(LEAST, BASE + EACH * dofs)


def _most_memory(memory: float | None = None) -> float:
    """Bytes that choices may take: a share of what there is, or what is given if that is less."""
    share = SHARE * process.capacity()
    return share if memory is None else min(share, memory)


def most_dofs(memory: float | None = None) -> float:
    """Degrees of freedom of the largest meshes that are chosen."""
    fit = (_most_memory(memory) - BASE) / EACH
    if memory is not None and fit < COARSE:
        least = process.gigabytes(peak_memory(COARSE))
        raise InputError(f"memory = {process.gigabytes(memory)}: a coarse mesh takes {least}")
    return min(DOFS, max(fit, COARSE))


def processes(size: float, memory: float | None = None) -> int:
    """How many processes of so many bytes fit, at least one."""
    return max(1, math.floor(min(_most_memory(memory) / size, 1e6)))
