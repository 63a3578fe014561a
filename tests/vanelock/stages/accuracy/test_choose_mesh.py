"""What an accuracy settles before the response: areas, reduction, element size."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock import parse_study
from vanelock.common import process
from vanelock.common.errors import InputError
from vanelock.mesh.element_size import element_size
from vanelock.mesh.refinement import casing_dofs, vane_dofs
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.stages.accuracy import choose_mesh, mesh_sizes
from vanelock.stages.accuracy.budget import budget

FREE = "accuracy = 0.05"
RATIO = 1.7
"""Error of the peak's amplitude over that of its frequency."""
NOTHING: Any = None
NOWHERE = Stages(NOTHING, silent)
"""Stages that nothing is asked of."""


def choice_of(text):
    return choose_mesh.choose_mesh(parse_study(text), NOWHERE)


def estimating(monkeypatch, error_of, dofs=lambda size: 27_000 * (0.025 / size) ** 2):
    """Let errors follow from element sizes alone; returns the studies that were asked about."""
    asked = []

    def tried(study, stages):
        asked.append(study)
        size = element_size(study.mesh.size, "vane")
        error = error_of(size)
        if isinstance(error, Exception):
            raise error
        share = np.array([3e-4])
        limits = SimpleNamespace(free_error=share, stuck_error=share, free_mode=0, stuck_mode=0)
        each = int(dofs(size)), int(dofs(element_size(study.mesh.size, "casing")))
        found = choose_mesh.Round(f"{size:g}", each, error, RATIO * error)
        return found, limits

    monkeypatch.setattr(choose_mesh, "_tried", tried)
    return asked


def test_the_first_mesh_within_its_share_is_taken(monkeypatch):
    asked = estimating(monkeypatch, lambda size: 0.02 * (size / 0.03) ** 1.0)
    found = choice_of(FREE)
    share, most = budget(parse_study(FREE)).shares["mesh"], budget(parse_study(FREE)).bearable
    amplitudes = [each.amplitude for each in found.rounds]
    assert [each <= most for each in amplitudes] == [False] * (len(asked) - 1) + [True]
    assert asked[0].mesh.size == "coarse"
    assert len(asked) <= 3
    assert amplitudes[-1] > 0.6 * share  # and not much finer than that
    # What the mesh leaves is shared anew.
    assert found.budget.shares["mesh"] == amplitudes[-1]
    assert sum(found.budget.shares.values()) == pytest.approx(0.05)
    assert found.short == ""
    assert found.study.mesh.size == asked[-1].mesh.size


def test_an_error_a_little_beyond_its_share_is_not_worth_another_mesh(monkeypatch):
    shares = budget(parse_study(FREE))
    assert shares.shares["mesh"] < shares.bearable < 0.05
    beyond = (shares.shares["mesh"] + shares.bearable) / 2 / RATIO
    asked = estimating(monkeypatch, lambda size: beyond)
    found = choice_of(FREE)
    assert len(asked) == 1
    assert found.short == ""
    assert found.budget.shares["mesh"] > shares.shares["mesh"]
    for source in ("harmonics", "frequencies"):
        assert 0.5 < found.budget.shares[source] / shares.shares[source] < 1


def test_the_largest_mesh_is_taken_where_the_share_is_out_of_reach(monkeypatch):
    estimating(monkeypatch, lambda size: 0.07 * (size / 0.025) ** 0.5)
    monkeypatch.setattr(mesh_sizes, "DOFS", 250_000)
    found = choice_of("accuracy = 0.001")
    size = found.study.mesh.size
    assert all(0.003 < each < 0.009 for each in size)
    vane, casing = found.study.vane, found.study.casing
    dofs = vane_dofs(vane, 16, size[0]) + casing_dofs(casing, vane.hook, 16, size[1], 3)
    assert 0.9 * mesh_sizes.DOFS < dofs <= 1.001 * mesh_sizes.DOFS
    assert f"estimated error {found.rounds[-1].amplitude:.1e} at" in found.short
    assert "was its share" in found.short


def test_no_mesh_is_chosen_that_memory_does_not_hold(monkeypatch):
    estimating(monkeypatch, lambda size: 0.07 * (size / 0.025) ** 0.5)
    monkeypatch.setattr(process, "_bounds", lambda: [process._Bound(4e9, 1e9, "a test's memory")])
    most = mesh_sizes.most_dofs()
    assert mesh_sizes.peak_memory(most) == pytest.approx(mesh_sizes.SHARE * 4e9)
    found = choice_of("accuracy = 0.001")
    dofs = mesh_sizes.unknowns(found.study, found.study.mesh.size)
    assert 0.9 * most < dofs <= 1.001 * most
    assert f"none larger than {most:,.0f} fit the memory" in found.short
    assert mesh_sizes.most_dofs(2e9) < most
    assert mesh_sizes.most_dofs(8e9) == most
    with pytest.raises(InputError, match=r"^memory = 1 GB: a coarse mesh takes 1\.\d GB$"):
        mesh_sizes.most_dofs(1e9)


def test_patches_that_a_mesh_cannot_hold_ask_for_a_finer_one(monkeypatch):
    refusal = InputError("vane: the mesh is too coarse to resolve the contact patches")
    asked = estimating(monkeypatch, lambda size: refusal if size > 0.022 else 0.01)
    found = choice_of(FREE)
    assert [study.mesh.size for study in asked] == ["coarse", (0.0212, 0.0113)]
    assert len(found.rounds) == 1
    estimating(monkeypatch, lambda size: InputError("vane: something else"))
    with pytest.raises(InputError, match="something else"):
        choice_of(FREE)


def test_a_given_mesh_is_kept_and_estimated(monkeypatch):
    asked = estimating(monkeypatch, lambda size: 0.07)
    found = choice_of(f'{FREE}\n[mesh]\nsize = "medium"')
    assert [study.mesh.size for study in asked] == ["medium"]
    assert found.rounds[0].error == 0.07
    assert found.short == ""
    assert "mesh" not in found.budget.shares


def test_modes_get_their_share_or_take_their_error_off(monkeypatch):
    estimating(monkeypatch, lambda size: 0.01)
    open_to = choice_of(FREE)
    assert open_to.study.rom.accuracy == pytest.approx(open_to.budget.shares["modes"])
    pinned = choice_of(f"{FREE}\n[rom]\naccuracy = 1e-3")
    assert pinned.study.rom.accuracy == 1e-3
    assert sum(pinned.budget.shares.values()) == pytest.approx(0.05 - 3e-4)
    assert sum(budget(parse_study(FREE)).shares.values()) == pytest.approx(0.05)
