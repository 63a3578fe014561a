"""Cases behind the figures: which, how often, around which scene."""

import pytest

from vanelock import parse_study
from vanelock.common.errors import InputError
from vanelock.published.sheets import GAP, case_of, case_words, planned_sheets

TEXT = """
[joints.interlock]
mu = 0.7
[response]
harmonics = 3
[campaign]
mu = [0.1, 0.2, 0.4]
reference_mu = 0.2
interference = ["1 um", "2 um"]
harmonics = [1, 3]
"""


@pytest.fixture
def plan():
    return planned_sheets(parse_study(TEXT), 0.05)


def test_the_base_has_the_reference_friction_and_one_harmonic(plan):
    assert plan.base.joints.interlock.mu == 0.2
    assert plan.base.response.harmonics == 1
    assert plan.base.response.coupling == "coupled"
    assert plan.study(case_of(plan)) == plan.base


def test_figures_share_cases(plan):
    listed = [name for sheet in plan.sheets.values() for name in sheet.cases]
    assert set(listed) == set(plan.cases)
    # mu = 0.4 at 2 um belongs to friction and to interference, three couplings each; the reference
    # to friction and harmonics.
    assert len(listed) - len(plan.cases) == 4
    assert len({repr(case.study) for case in plan.cases.values()}) == len(plan.cases)


def test_each_sheet_varies_what_its_figure_does(plan):
    def values(sheet, key):
        return [key(plan.study(name)) for name in plan.sheets[sheet].cases]

    mu, harmonics = (
        values("friction", lambda s: s.joints.interlock.mu),
        values("harmonics", lambda s: (s.response.harmonics, s.response.harmonic_diameters)),
    )
    assert mu == [0.1] * 3 + [0.2] * 3 + [0.4] * 3
    assert harmonics == [(1, "wave"), (3, "wave"), (3, "sector")]
    locks = values("interference", lambda s: s.joints.interlock)
    pressed = [(lock.interference, lock.mu) for lock in locks]
    assert pressed == [(1e-6, 0.4)] * 3 + [(2e-6, 0.4)] * 3
    couplings = values("interference", lambda s: s.response.coupling)
    assert couplings == ["coupled", "uncoupled", "constant-load"] * 2
    assert values("hooks", lambda s: s.joints.interlock.interference) == [GAP]
    assert values("stuck", lambda s: s.excitation.force) == pytest.approx([1.5] * 3)


def test_an_unbalance_is_made_smaller_as_a_force_is():
    text = TEXT + '[excitation]\nunbalance = "1.5 kg*mm"\n'
    plan = planned_sheets(parse_study(text), 0.1)
    loads = [plan.study(name).excitation.unbalance for name in plan.sheets["stuck"].cases]
    assert loads == pytest.approx([1.5e-4] * 3)


def test_an_interlock_apart_is_refused():
    apart = parse_study(TEXT.replace("mu = 0.7", 'interference = "-1 um"'))
    with pytest.raises(InputError, match="joints.interlock.interference = -1e-06: must be > 0"):
        planned_sheets(apart, 0.1)


def test_harmonics_of_the_scene_have_their_own_diameters():
    sector = parse_study(TEXT.replace("[campaign]", 'harmonic_diameters = "sector"\n[campaign]'))
    assert planned_sheets(sector, 0.1).base == planned_sheets(parse_study(TEXT), 0.1).base


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ('[sweep]\n"joints.interlock.mu" = [0.1]', "campaign: cannot be combined with sweep"),
        ("[excitation]\nengine_orders = [1, 2]", "combined with excitation.engine_orders"),
        ('[response]\nfriction = "isotropic"', 'combined with response.friction = "isotropic"'),
        ("[response]\nsamples = 512", "combined with response.samples"),
    ],
)
def test_what_a_campaign_cannot_have_is_refused(more, expected):
    with pytest.raises(InputError, match=expected):
        parse_study(f"[campaign]\n{more}")


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("mu = [0.3, 0.1]", "campaign.mu = [0.3, 0.1]: must ascend"),
        ("reference_mu = 0.2", "campaign.reference_mu = 0.2: must be one of mu"),
        ("mu = [0.3]", "expected at least 2"),
        ("interference = [0, 1e-6]", "campaign.interference[0] = 0: interference must be > 0 m"),
        ("slants = [80]", "slants[0] = 80: slant of the interlock faces must be <= 60 deg"),
    ],
)
def test_wrong_lists_are_one_clear_line(table, expected):
    with pytest.raises(InputError) as error:
        parse_study(f"[campaign]\n{table}")
    (line,) = str(error.value).splitlines()[:1]
    assert expected in line


def test_names_in_words(plan):
    words = [case_words(name) for name in plan.sheets["interference"].cases]
    assert words[:2] == ["μ = 0.4, 1 µm", "μ = 0.4, 1 µm, uncoupled"]
    assert case_words(plan.sheets["hooks"].cases[0]) == "interlock apart"
    assert case_words(plan.sheets["harmonics"].cases[-1]) == "H = 3, one diameter"
    assert case_words(case_of(plan)) == "reference"
