"""A small model whose entries every format prints exactly: sums of few powers of two."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

NODES = np.array([11, 4, 7])
DATA = Path(__file__).parent / "data"


class Model:
    """Nine displacements of three nodes, and their labels as a table and as Ansys's mapping."""

    def __init__(self) -> None:
        random = np.random.default_rng(5)
        loose = random.integers(-3, 4, (9, 9)) * (random.random((9, 9)) < 0.6)
        self.K: NDArray[np.float64] = 512.0 * (loose @ loose.T + 9 * np.eye(9))
        few = random.integers(-1, 2, (9, 9)) * (random.random((9, 9)) < 0.2)
        self.M: NDArray[np.float64] = 0.125 * (few @ few.T + 12 * np.eye(9))
        self.node = np.repeat(NODES, 3)
        self.direction = np.tile(np.arange(3), 3)

    def write_nodes(self, folder: Path) -> Path:
        """A table of positions."""
        path = folder / "nodes.csv"
        rows = [f"{node},{0.5 * k},{k},0" for k, node in enumerate(NODES)]
        path.write_text("\n".join(["node,x,y,z", *rows]) + "\n")
        return path

    def write_dofs(self, folder: Path) -> Path:
        """A table of labels."""
        path = folder / "dofs.csv"
        rows = [f"{n},{'xyz'[d]}" for n, d in zip(self.node, self.direction, strict=True)]
        path.write_text("\n".join(["node,direction", *rows]) + "\n")
        return path

    def write_mapping(self, folder: Path) -> Path:
        """Labels as HBMAT writes them."""
        path = folder / "file.mapping"
        rows = [
            f"{k:12d}{n:12d}     U{'XYZ'[d]}"
            for k, (n, d) in enumerate(zip(self.node, self.direction, strict=True), start=1)
        ]
        path.write_text("\n".join(["    Matrix Eqn        Node     DOF", *rows]) + "\n")
        return path


@pytest.fixture(scope="session")
def model() -> Model:
    return Model()
