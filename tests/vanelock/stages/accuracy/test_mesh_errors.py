"""What meshes add to a peak: against stiffer structures; where they err."""

from dataclasses import replace

import numpy as np
import pytest

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import nonlinear
from vanelock.stages.accuracy.evidence import _error_places, amplitude_errors_of
from vanelock.stages.accuracy.mesh_errors import AmplitudeErrors, amplitude_error
from vanelock.stages.parts.study_structure import StudyStructure
from vanelock.stages.response.limits import frequencies

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
