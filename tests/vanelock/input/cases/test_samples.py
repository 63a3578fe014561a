"""Samples of keys that scatter: each key's own distribution, evenly covered, the same each time."""

import numpy as np
import pytest
from scipy import stats

from tests.vanelock.input.conftest import complaint
from vanelock import Scene, Study, cases, parse_study
from vanelock.common.errors import InputError
from vanelock.files import checked, load_study
from vanelock.input.cases.samples import samples

MU = '"joints.interlock.mu"'
KT = '"joints.interlock.kt"'


def study(text, count=64, seed=1):
    return parse_study(f"seed = {seed}\n[scatter]\nsamples = {count}\n[scatter.keys]\n{text}")


LAWS = {
    "uniform = [0.1, 0.5]": stats.uniform(0.1, 0.4),
    "normal = [0.3, 0.02]": stats.norm(0.3, 0.02),
    "lognormal = [0.3, 0.1]": stats.lognorm(np.log(10 / 9) ** 0.5, scale=0.3 * 0.9**0.5),
    "normal = [0.2, 0.2], within = [0.1, 0.3]": stats.truncnorm(-0.5, 0.5, 0.2, 0.2),
    "normal = [0.1, 0.2], within = [0, inf]": stats.truncnorm(-0.5, np.inf, 0.1, 0.2),
}


@pytest.mark.parametrize("text", LAWS)
def test_one_sample_lies_in_each_part_of_the_distribution(text):
    (found,) = samples(study(f"{MU} = {{ {text} }}\n")).values()
    part = np.floor(64 * LAWS[text].cdf(found)).astype(int)
    assert sorted(part) == list(range(64))


def test_keys_are_paired_at_random_and_the_seed_says_how():
    text = f"{MU} = {{ uniform = [0.1, 0.5] }}\n{KT} = {{ uniform = [1e6, 2e6] }}\n"
    one, same, other = (samples(study(text, seed=seed)) for seed in (3, 3, 4))
    assert one == same != other
    assert abs(stats.spearmanr(*one.values()).statistic) < 0.4
    (first, *_) = found = cases(study(text, seed=3))
    assert [case.name for case in found][:2] == ["sample=01", "sample=02"]
    assert first.values == {key: values[0] for key, values in one.items()}
    assert {"joints.interlock.mu": first.study.joints.interlock.mu}.items() <= first.values.items()
    assert not first.study.scatter


def test_numbers_carry_units_and_are_allowed_by_their_keys():
    text = 'joints.interlock.interference = { uniform = ["1 um", 3e-6] }\n'
    (found,) = samples(study(text)).values()
    assert 1e-6 <= min(found) < 1.1e-6
    assert 2.9e-6 < max(found) <= 3e-6
    text = f"{MU} = {{ normal = [0.1, 0.1] }}"
    with pytest.raises(InputError, match=r"sample \d+: joints.interlock.mu = -.*within = "):
        cases(study(text))


TABLE = """
"joints.interlock.muu" = { uniform = [0, 1] } | "joints.interlock.muu": unknown key; nearest \
known key: joints.interlock.mu
"response.harmonics" = { uniform = [1, 3] } | "response.harmonics": only keys that hold a number \
with a fraction can scatter
MU = { uniform = [0.5, 0.1] } | MU.uniform = [0.5, 0.1]: must be [low, high] with low < high
MU = { normal = [0.3, 0] } | MU.normal = [0.3, 0]: standard deviation must be > 0
MU = { lognormal = [-1, 1] } | MU.lognormal = [-1, 1]: mean must be > 0
KT = { uniform = ["1 N", 2e6] } | KT.uniform = ["1 N", 2000000.0]: expected a number in N/m, or \
text with a unit such as "1 N/m"
MU = { normal = [1, 0.1], within = [9, inf] } | MU.within = [9, inf]: leaves nothing of it
MU = { uniform = [0.1, nan] } | MU.uniform = [0.1, nan]: expected numbers
MU = { uniform = [0.1, inf] } | MU: numbers too large
MU = { lognormal = [1e300, 1e-300] } | MU: numbers too large or \
too small for a lognormal distribution
MU = { normal = [1e308, 1e308] } | MU: numbers too large or too \
small for a normal distribution
"""
MISTAKES = TABLE.replace("MU", MU).replace("KT", KT).strip().splitlines()


@pytest.mark.parametrize(
    ("text", "line"),
    [
        *((text, f"scatter.keys.{line}") for text, line in (x.split(" | ") for x in MISTAKES)),
        (f"{MU} = {{ uniform = [0, 1] }}\n[sweep]\n{KT} = [1e6]", "scatter: give either this, or"),
    ],
)
def test_mistakes(text, line):
    assert complaint(text, lambda text: cases(study(text))).startswith(line)


TOO_LITTLE_OR_TOO_MUCH = {
    "within = [0, 1]": "needs one of uniform, normal, lognormal, not none",
    "normal = [1]": "normal.*must be given",
    "uniform = [0, 1], normal = [0, 1]": "not uniform and normal",
    "uniform = [0, 1], within = [0, 1]": "within: uniform has its ends already",
    "uniform = [true, 1]": ".uniform.0..*: expected a number, or text with a unit",
    "uniform = [[1], 1]": ".uniform.0..*: expected a number, or text with a unit",
    "low = 0.1": "unknown key; known here: uniform, normal, lognormal, within",
}


@pytest.mark.parametrize("text", TOO_LITTLE_OR_TOO_MUCH)
@pytest.mark.parametrize("key", [MU, MU.strip('"')])
def test_distributions_that_say_too_little_or_too_much(tmp_path, key, text):
    """In one line, with quotes round the key and without."""
    file = tmp_path / "vane.toml"
    file.write_text(f"[scatter.keys]\n{key} = {{ {text} }}")
    with pytest.raises(InputError, match=TOO_LITTLE_OR_TOO_MUCH[text]) as caught:
        load_study(file)
    assert str(caught.value).splitlines() == [str(caught.value)]
    assert f"scatter.keys.{MU}" in str(caught.value)


@pytest.mark.parametrize("schema", [Study, Scene])
@pytest.mark.parametrize("table", [{}, {"samples": 3}])
def test_keys_must_scatter(schema, table):
    with pytest.raises(InputError, match="scatter.keys: must be given") as caught:
        checked(schema, {"scatter": table}, "vane.toml")
    assert str(caught.value).count("scatter") == 1


def test_rows_vary_together():
    text = f'[rows]\n{MU} = [0.1, 0.2, 0.3]\n{KT} = [1e6, "2 N/um", 1e6]\n'
    found = cases(parse_study(text + '[sweep]\n"response.harmonics" = [1, 3]'))
    rows = (0.1, 1e6), (0.2, 2e6), (0.3, 1e6)
    assert [tuple(case.values.values()) for case in found] == [
        (*r, h) for r in rows for h in (1, 3)
    ]
    assert found[0].name == "mu=0.1,kt=1N_um,harmonics=1"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"{MU} = [0.1, 0.2]\n{KT} = [1e6]", "rows: lists must be equally long, not"),
        (f"{MU} = [0.1, 0.1]", "rows: mu=0.1 is there twice"),
        (f"{MU} = []", f"rows.{MU} = []: needs at least one value"),
        ('"joints.mu" = [1]', 'rows."joints.mu": unknown key'),
        (f"{MU} = [-1]", "rows: joints.interlock.mu = -1: friction coefficient must be >= 0"),
        (
            f"{MU} = [-1]\n[sweep]\n{KT} = [1e6]",
            "rows and sweep: joints.interlock.mu = -1, joints.interlock.kt = 1000000.0: "
            "joints.interlock.mu = -1: friction coefficient must be >= 0",
        ),
        ('"vane.thickness" = ["9 m"]', "rows: vane.thickness = 9.0: thickness of an aerofoil"),
        (f"{MU} = [0.1]\n[sweep]\n{MU} = [0.2]", f"rows.{MU}: is in sweep too"),
    ],
)
def test_mistakes_in_rows(text, line):
    assert complaint(f"[rows]\n{text}", lambda text: cases(parse_study(text))).startswith(line)
