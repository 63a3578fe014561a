"""Picture of the mesh study."""

from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray

from benchmarks.mesh.families import Row

matplotlib.use("Agg")
import matplotlib.pyplot as plt

Floats = NDArray[np.float64]


def errors(
    groups: dict[str, list[Row]],
    exact: Floats,
    mean: Callable[[Row, Floats], float],
    unit: float,
    target: Path,
) -> None:
    """Mean error of each family against dofs and against CPU time."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), sharey=True, constrained_layout=True)
    for number, (name, rows) in enumerate(groups.items()):
        error = [mean(row, exact) for row in rows]
        style = {"color": f"C{number}", "marker": "o" if name.startswith("tetra") else "s", "ms": 4}
        style["ls"] = "--" if "local" in name else "-"
        axes[0].loglog([row.dofs for row in rows], error, label=name, **style)
        axes[1].loglog([row.solving / unit for row in rows], error, **style)
    axes[0].set_xlabel("degrees of freedom")
    axes[1].set_xlabel("CPU time of assembly, factors and modes, in units")
    axes[0].set_ylabel("mean error of ten frequencies")
    for ax in axes:
        ax.grid(True, which="both", alpha=0.3)
    axes[0].legend(fontsize=8)
    figure.savefig(target, dpi=120)
    plt.close(figure)
