"""Modes of a vane alone in the coordinates of its ring."""

from collections.abc import Callable

import numpy as np

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import parse_study
from vanelock.analyses.mistuning import _vane_modes_step
from vanelock.pipeline.step import Stages

RIGID = 6
"""Modes of a body that nothing holds."""


def test_modes_of_a_vane_alone_are_all_its_stiffness(
    stages: Stages, ring_text: Callable[..., str]
) -> None:
    """Σ g k gᵀ of all of them is what (1 + δ)² times the modulus adds, over (1 + δ)² - 1."""
    text, deviation = ring_text("tetra10", COARSER) + '[mesh]\ncorrection = "none"\n', 0.03
    modulus = parse_study(text).material.vane.E
    stiffer = f"[material.vane]\nE = {modulus * (1 + deviation) ** 2!r}\n"
    planned, other = planned_of(text), planned_of(text + stiffer)
    whole = planned.structure.whole
    vane = stages.get(planned.part("vane", 0))
    modes = stages.get(_vane_modes_step(planned, vane.size - RIGID))
    system, changed = stages.get(whole), stages.get(other.structure.whole)
    for k in range(7):
        g = modes.rows[k]
        added = changed.at(k).K - system.at(k).K
        found = ((1 + deviation) ** 2 - 1) * (g.conj().T * modes.stiffness) @ g
        np.testing.assert_allclose(found, added, atol=1e-7 * np.abs(added).max())
