"""Sweeps: the product of all lists, every value checked as its key would be; names of cases."""

import re
import tomllib
from itertools import product

import pytest

from tests.vanelock.input.conftest import complaint
from vanelock import Study, cases, load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.input.cases.names import slug, valued, words
from vanelock.input.cases.sweep import label
from vanelock.input.cases.values import with_values
from vanelock.results.figures.curves import _merged


def test_product_runs_the_last_key_fastest():
    text = '[sweep]\n"joints.interlock.mu" = [0.15, 0.3]\n"response.harmonics" = [1, 3, 5]'
    found = cases(parse_study(text))
    settings = [(c.study.joints.interlock.mu, c.study.response.harmonics) for c in found]
    assert settings == [*product((0.15, 0.3), (1, 3, 5))]
    assert found[1].name == "mu=0.15,harmonics=3"
    assert found[1].values == {"joints.interlock.mu": 0.15, "response.harmonics": 3}
    assert all(not c.study.sweep for c in found)


def test_a_study_with_a_mesh_of_its_own_is_swept_too(tmp_path):
    (path := tmp_path / "vane.inp").touch()
    text = f'[vane]\nmesh = "{path}"\n[sweep]\njoints.hook.mu = [0.1, 0.2]'
    assert [case.study.joints.hook.mu for case in cases(parse_study(text))] == [0.1, 0.2]


def test_cases_have_values_and_names():
    """No sweep is one; keys may stand without quotes, and defaults may depend on others."""
    (case,) = cases(parse_study(""))
    assert (case.name, case.values) == ("nominal", {})
    found = cases(parse_study('[sweep]\nvane.chord = ["40 mm", 0.045]'))
    assert [case.study.vane.chord for case in found] == [pytest.approx(0.04), 0.045]
    study = parse_study(
        '[sweep]\n"joints.hook.mu" = [0.2]\n"joints.interlock.mu" = [0.3]\n"vane.chord" = [0.04]'
    )
    assert cases(study)[0].name == "hook.mu=0.2,interlock.mu=0.3,chord=40mm"
    found = cases(parse_study('[sweep]\n"excitation.unbalance" = [1e-3, 2e-3]'))
    assert [c.study.excitation.unbalance for c in found] == [1e-3, 2e-3]
    assert [c.study.excitation.force_per_node for c in found] == [0, 0]


MISTAKES = """
"joints.interlock.muu": unknown key; nearest known key: joints.interlock.mu
"joints.interlock": only keys that hold a number or a choice of words can be swept
"joints.interlock.mu"[1] = -0.1: friction coefficient must be >= 0
"response.coupling"[1] = "loose": coupling of the static and the dynamic balance must be one of \
"coupled", "uncoupled" or "constant-load"
"response.coupling"[1] = "coupled": the same as entry 0
"vane.chord"[1] = 45: chord of an aerofoil must be <= 0.5 m; 45 is 45 m: "45 mm"?
"vane.chord" = []: needs at least one value
"vane.chord"[1] = "40 mm": the same as entry 0
"ring.sectors"[1] = 16.5: expected a whole number
"""
RIGHT = {"vane.chord": "0.04", "response.coupling": '"coupled"', "ring.sectors": "16"}


@pytest.mark.parametrize("line", MISTAKES.strip().splitlines())
def test_mistakes(tmp_path, line):
    ((key, entry, value),) = re.findall(r'^"(.*?)"(\[1\])?(?: = (.*?))?: ', line)
    values = f"[{RIGHT.get(key, '0.1')}, {value}]" if entry else value or "[0.1]"
    path = tmp_path / "vane.toml"
    path.write_text(f'[sweep]\n"{key}" = {values}')
    assert complaint(path, load_study) == f"{path}: sweep.{line}"


def test_impossible_combinations_and_too_many_cases_are_refused():
    study = parse_study(
        '[sweep]\n"vane.thickness" = [0.002, 0.004]\n"vane.edge_thickness" = [0.001, 0.003]\n'
        "[vane]\nthickness = 0.01\nedge_thickness = 0.0001"
    )
    with pytest.raises(
        InputError, match=r"vane\.thickness = 0\.002, vane\.edge_thickness = 0\.003"
    ):
        cases(study)
    keys = ("joints.hook.mu", "joints.interlock.mu", "joints.hook.kn")
    many = ", ".join(f"{0.1 + i * 1e-3}" for i in range(47))  # 47^3 = 103,823
    study = parse_study("[sweep]\n" + "".join(f'"{key}" = [{many}]\n' for key in keys))
    with pytest.raises(InputError, match="103823 cases: at most 100000"):
        cases(study)


def test_labels_name_what_tells_groups_apart():
    found = cases(
        parse_study('[sweep]\n"joints.interlock.mu" = [0.1, 0.2]\n"response.harmonics" = [1, 3]')
    )
    assert label(found, ["a"] * 4) == [""] * 4
    assert label(found, ["a", "a", "b", "b"]) == ["mu=0.1", "mu=0.1", "mu=0.2", "mu=0.2"]
    assert label(found, ["a", "b", "a", "b"]) == ["harmonics=1", "harmonics=3"] * 2


@pytest.mark.parametrize(
    "changes",
    [
        {"joints.interlock.mu": 0.2, "response.harmonics": 3},
        {"excitation.engine_order": 5, "vane.chord": "41 mm"},
        {"temperature.speed": None},
        {"outputs.monitor": "vane output 2, radial", "material.vane.nu": 0.29},
    ],
)
def test_a_changed_study_is_the_one_that_its_file_would_give(changes):
    """Although only the tables with a change are checked anew."""
    text = """
        vane.thickness = "5 mm"
        joints.hook.mu = 0.1
        material.vane.E = "180 GPa"
        outputs.gauges = [{ aerofoil = 1, span = 0.1, chord = 0.5 }]
        sweep."joints.interlock.mu" = [0.2]
    """
    study = parse_study(text)
    found = with_values(study, changes)
    data = tomllib.loads(text)
    del data["sweep"]
    for key, value in changes.items():
        table, *rest, last = key.split(".")
        inner = data.setdefault(table, {})
        for name in rest:
            inner = inner.setdefault(name, {})
        inner[last] = value
    expected = Study.model_validate(data)
    assert found == expected
    assert found.model_dump(exclude_unset=True) == expected.model_dump(exclude_unset=True)


def test_people_and_files_get_the_same_name():
    name = "mu=0.15,interference=17um,kn=20N_um,angle=-3.5deg,coupling=uncoupled"
    assert words(name) == "μ = 0.15, interference = 17 µm, kn = 20 N/µm, angle = -3.5°, uncoupled"
    assert slug(name) == "mu0.15_interference17um_kn20N_um_angle-3.5deg_couplinguncoupled"
    assert slug("hook.mu=0.15,kn=1e+06") == "hook.mu0.15_kn1e+06"
    for name, text in (
        ("size=coarse,monitor=upper 17um", "size = coarse, monitor = upper 17um"),
        ("mu=0.15,harmonics=3", "μ = 0.15, H = 3"),
        ("nominal", "nominal"),
        (
            "engine_order=-2,coupling=constant-load,friction=isotropic,mu=0.3",
            "EO = -2, constant-load, isotropic friction, μ = 0.3",
        ),
    ):
        assert words(name) == text
    assert words("mu=0.15,harmonics=3", without="harmonics") == "μ = 0.15"
    assert _merged(["mu=0.1,kn=5", "mu=0.3,kn=5"]) == "μ = 0.1 or 0.3, kn = 5"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (4e-6, "m", "4um"),
        (1.23456789e-5, "m", "12.3456789um"),
        (1.67e7, "N/m", "16.7N_um"),
        (1e-3, "kg m", "1000gmm"),
        (0.15, "", "0.15"),
        ("coupled", "", "coupled"),
    ],
)
def test_a_value_in_a_name(value, unit, text):
    assert valued(value, unit) == text
