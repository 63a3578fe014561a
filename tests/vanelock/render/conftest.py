"""A sector of a plain ring made by hand: what the render tests draw where no mesh is needed."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.mesh import Part
from vanelock.render import style

Build = Callable[..., Part]


def radial_wave(part: Part, nodal_diameter: int, amplitude: float) -> NDArray[np.complex128]:
    """(m, 3) u_r = a e^{-i ND θ}."""
    angle = np.arctan2(part.points[:, 1], part.points[:, 0])
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    found: NDArray[np.complex128] = (
        amplitude * radial * np.exp(-1j * nodal_diameter * angle)[:, None]
    )
    return found


@pytest.fixture(scope="session")
def sector(lattice: Build) -> Build:
    """Function that makes an annular sector of straight-sided quadratic tetrahedra."""

    def build(
        name: str = "casing",
        inner: float = 0.5,
        outer: float = 0.6,
        length: float = 0.1,
        sectors: int = 8,
        divisions: tuple[int, int, int] = (2, 4, 2),
    ) -> Part:
        def bent(p: NDArray[np.float64]) -> NDArray[np.float64]:
            r, angle = inner + (outer - inner) * p[:, 0], 2 * np.pi / sectors * p[:, 1]
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), length * p[:, 2]])

        part = lattice(divisions, bent, sectors=sectors)
        faces = part.node_sets
        sets = {"left": faces["y0"], "right": faces["y1"], "fixed": faces["z0"]}
        sets["hook_front"] = np.intersect1d(faces["x0"], faces["z1"])
        return replace(part, name=name, node_sets={**sets, "output": np.array([0])})

    return build


@pytest.fixture
def bars(monkeypatch):
    """Lower end, upper end and label of each colour bar as it stands in its figure."""
    found = []
    draw = style.colour_bar

    def noted(axes, *given):
        bar = draw(axes, *given)
        found.append((*axes.get_ylim(), axes.get_ylabel()))
        return bar

    monkeypatch.setattr(style, "colour_bar", noted)
    return found


@pytest.fixture
def figures(monkeypatch):
    """Figures that would be written."""
    kept = []
    monkeypatch.setattr(style, "write", lambda figure, path: kept.append(figure))
    return kept
