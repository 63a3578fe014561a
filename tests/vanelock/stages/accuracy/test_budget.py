"""An accuracy split into shares."""

import numpy as np
import pytest
from scipy.optimize import minimize

from vanelock import parse_study
from vanelock.stages.accuracy.budget import LEAST, LOWEST, _costs_of, _split, budget, pins


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
