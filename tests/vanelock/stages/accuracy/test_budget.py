"""An accuracy split into shares, what meshes add to a peak, and what a run will take."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import nonlinear, parse_study, run_study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.stages import cost_estimate
from vanelock.stages.accuracy import mesh_sizes
from vanelock.stages.accuracy.budget import LEAST, LOWEST, _costs_of, _split, budget, pins
from vanelock.stages.accuracy.evidence import _error_places, amplitude_errors_of
from vanelock.stages.accuracy.mesh_errors import AmplitudeErrors, amplitude_error
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.response.limits import frequencies


@pytest.mark.parametrize("accuracy", [0.2, 1e-2, 1e-4])
@pytest.mark.parametrize(
    "sources",
    [("mesh", "modes", "harmonics", "frequencies"), ("harmonics", "frequencies"), ("modes",)],
)
def test_shares_sum_up_to_the_accuracy_at_least_cost(sources, accuracy):
    shares = _split(accuracy, sources)
    assert sum(shares.values()) == pytest.approx(accuracy, rel=1e-9)
    assert min(shares.values()) >= LOWEST * accuracy * (1 - 1e-12)

    def cost(parts):
        return sum(
            _costs_of(sources)[name].scale * (accuracy * part) ** -_costs_of(sources)[name].power
            for name, part in zip(sources, parts, strict=True)
        )

    found = minimize(
        lambda parts: np.log(cost(parts)),
        np.full(len(sources), 1 / len(sources)),
        bounds=[(LOWEST, 1)] * len(sources),
        constraints={"type": "eq", "fun": lambda parts: sum(parts) - 1},
    )
    own = cost([share / accuracy for share in shares.values()])
    assert own <= cost(found.x) * (1 + 1e-6)


def test_what_costs_most_gets_most():
    shares = budget(parse_study("accuracy = 0.01")).shares
    assert max(shares, key=lambda name: shares[name]) == "mesh"


def test_what_the_study_sets_is_pinned():
    study = parse_study(
        'accuracy = 0.01\n[mesh]\nsize = "coarse"\n[rom]\nmodes = 8\n[response]\npoints = 30'
    )
    assert pins(study) == {
        "mesh": "mesh.size",
        "modes": "rom.modes",
        "frequencies": "response.points",
    }
    assert set(budget(study).shares) == {"harmonics"}
    assert pins(parse_study("")) == {}
    # A default that is written out is set, too.
    assert pins(parse_study("[response]\nharmonics = 3")) == {"harmonics": "response.harmonics"}


def test_a_mesh_of_the_users_is_pinned(tmp_path):
    study = parse_study(f'accuracy = 0.01\n[vane]\nmesh = "{tmp_path}/vane.inp"')
    assert pins(study)["mesh"] == "vane.mesh"


def test_the_error_of_what_is_pinned_comes_off_first():
    study = parse_study('accuracy = 0.01\n[mesh]\nsize = "coarse"\n[rom]\naccuracy = 1e-2')
    assert sum(budget(study, 0.004).shares.values()) == pytest.approx(0.006)
    # What is left must be something, and the run warns.
    assert sum(budget(study, 0.02).shares.values()) == pytest.approx(LEAST * 0.01)


COARSE = '[mesh]\nsize = "coarse"\n'


def estimated(text, given=None):
    found = cost_estimate.estimated(cases(parse_study(text)), given)
    assert found is not None
    return found


def test_a_coarse_run_is_known_to_a_factor_of_two():
    """Measured: 37,473 degrees of freedom, 1.46 GB, 195 MB."""
    found = estimated(COARSE)
    assert found.dofs == pytest.approx(37473, rel=0.25)
    assert found.memory == pytest.approx(1.46e9, rel=0.1)
    assert found.disk == pytest.approx(195e6, rel=0.3)


def test_what_an_accuracy_takes_is_within_what_is_chosen_at_most():
    fine, rough = estimated("accuracy = 0.01"), estimated("accuracy = 0.2")
    assert fine.dofs == pytest.approx(290_295, rel=0.25)  # measured, and 4.24 GB of 173,280
    assert rough.dofs < 0.3 * fine.dofs
    assert mesh_sizes.peak_memory(173_280) == pytest.approx(4.24e9, rel=0.1)
    assert mesh_sizes.peak_memory(441_675) == pytest.approx(10.28e9, rel=0.1)
    assert estimated("accuracy = 0.01", 2e9).memory == pytest.approx(2e9)


def test_an_accuracy_out_of_reach_is_said_before_anything_is_computed():
    assert estimated("accuracy = 0.01", 8e9).warning == ""
    found = estimated("accuracy = 0.001", 8e9)
    assert found.warning.startswith("accuracy = 0.001 asks for meshes of about 7,000,000 degrees")
    assert "the largest that are chosen here have 310,000 and leave an error of about 0.007" in (
        found.warning
    )
    pinned = '\n[mesh]\nsize = "coarse"'
    assert estimated(f"accuracy = 0.001{pinned}", 8e9).warning == ""
    assert estimated("accuracy = 0.01\n[mesh]\ncorrection = 'none'", 3e9).warning


def test_words_round_to_what_is_known():
    words = cost_estimate.CostEstimate(62870.0, 1.69e9, 88.0, 3.3e8).words()
    assert words == {
        "unknowns": "63,000 degrees of freedom",
        "memory": "1.7 GB of memory",
        "time": "90 s on one core",
        "disk": "0.33 GB on disk",
    }
    for seconds, text in ((3.2, "3 s"), (130, "2 min"), (8000, "2 h"), (3e6, "30 days")):
        assert cost_estimate.CostEstimate(1, 1, seconds, 1).words()["time"] == f"{text} on one core"


def test_memory_that_no_mesh_fits_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"^memory = 0.2 GB: a coarse mesh takes 1\.\d GB$"):
        run_study(parse_study(COARSE), tmp_path / "run", memory=2e8)


def test_processes_are_as_many_as_fit():
    assert mesh_sizes.processes(1e9, 3.5e9) == 3
    assert mesh_sizes.processes(1e9, 0.5e9) == 1


PARTS = np.array([[0.01, -0.03], [0.02, -0.04]])
SMALL = 0.003
"""Share of what the meshes add by which a structure is made stiffer."""


def errors_of(planned, stages):
    own = amplitude_errors_of(planned)
    assert own is not None
    return stages.get(own)


def test_each_part_moves_the_peak_as_a_stiffer_structure_says(stages, ring_text):
    text = ring_text("tetra10", COARSER) + "[response]\nharmonics = 1\n"
    planned = planned_of(text)
    found = errors_of(planned, stages)
    system, study = stages.get(planned.system), planned.case.study
    near = frequencies(study, stages.get(planned.linear.limits))
    options = nonlinear.Options(1)
    known = nonlinear.peak_response(system, "force", [1.0], near, options)
    for part in range(2):
        for column, k in enumerate((0, system.nodal_diameter(1))):
            excess = stages.get(StudyStructure(study).mesh_excess(k)).diameters[k]
            one, added = system.diameters[k], excess.stiffness[part]
            K = one.K + SMALL * (added if np.iscomplexobj(one.K) else added.real)
            stiffer = replace(system, diameters={**system.diameters, k: replace(one, K=K)})
            moved = nonlinear.peak_response(stiffer, "force", [1.0], near, options)
            change = (moved.amplitude[0] / known.amplitude[0] - 1) / SMALL
            assert found.parts[part, column] == pytest.approx(change, rel=0.02)
    assert found.corrected
    beside = planned_of(text + "range = [1000, 1020]\n")
    assert np.isnan(errors_of(beside, stages).total)  # no peak lies there


def test_a_quarter_is_in_doubt_and_all_of_it_where_it_is_not_taken_off():
    corrected, as_it_is = (AmplitudeErrors(PARTS, each) for each in (True, False))
    assert corrected.total == pytest.approx(0.1 / 4)
    assert as_it_is.total == pytest.approx(0.04 + 0.1 / 4)
    assert amplitude_error(corrected, 0.5) == corrected.total


def test_the_usual_ratio_to_the_error_of_frequency_stands_for_a_peak_that_is_not_known():
    unknown = AmplitudeErrors(np.full((2, 2), np.nan), True)
    assert amplitude_error(unknown, 0.01) == pytest.approx(0.03)


@pytest.fixture
def parts(lattice):
    """A cube of twelve slices of tetrahedra along x, and another far above it."""
    bar = lattice((12, 1, 1), lambda p: p, "tetra")
    return [bar, replace(bar, points=bar.points + np.array([0.0, 0.0, 100.0]))]


def test_the_worst_place_is_described_with_what_lies_around_it(parts):
    count = len(parts[0].cells)
    middles = parts[0].points[parts[0].cells].mean(axis=1)
    energies = [np.full(count, 1.0), np.full(count, 0.5)]
    worst = int(np.argmin(np.linalg.norm(middles - [9.5 / 12, 0.5, 0.5], axis=1)))
    energies[1][worst] = 500.0
    found = _error_places(parts, energies)
    total = 1.0 * count + 0.5 * (count - 1) + 500
    assert found.part[0] == 1
    np.testing.assert_allclose(found.position[0], middles[worst] + [0, 0, 100])
    assert 500 / total < found.share[0] < 1
    assert (np.diff(found.share) <= 0).all()
    assert found.share.sum() <= 1 + 1e-12
    rows = found.table.shown
    assert rows[0][0] == "casing"
    assert rows[0][1] == pytest.approx(100 * found.share[0])


def test_the_mean_density_over_the_volume_is_one(parts):
    """At nodes: energies of the elements around over their volumes, both in all of one size."""
    count = len(parts[0].cells)
    found = _error_places(parts, [np.full(count, 3.0), np.full(count, 3.0)])
    np.testing.assert_allclose(found.vane, 1, rtol=1e-9)
    np.testing.assert_allclose(found.casing, 1, rtol=1e-9)
