"""The cache: keys, steps that cases share, and entries that come back whole or not at all."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock import parse_study
from vanelock.commands.run.graph import steps_of
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import value_at, with_values
from vanelock.input.schema.structure.structure import leaves
from vanelock.pipeline.cache import Cache, key_of
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages, reachable, step
from vanelock.stages.plan import plan


@dataclass(frozen=True)
class Numbers(Product):
    values: NDArray[np.float64] = field(metadata={"unit": "m"})
    name: str


@pytest.fixture
def noticed():
    return []


@pytest.fixture
def cache(tmp_path, noticed):
    return Cache(tmp_path / "cache", noticed.append)


def entry(cache):
    (path,) = cache.folder.rglob("*.h5")
    return path


def test_entries_come_back_to_the_last_bit(cache, noticed):
    product = Numbers(np.random.default_rng(1).normal(size=1000), "mine")
    cache.store("a stage", "key", product, 1.25)
    found = cache.load("a stage", "key", Numbers)
    assert np.array_equal(found.product.values, product.values)
    assert (found.product.name, found.seconds) == ("mine", 1.25)
    assert cache.load("a stage", "other", Numbers) is None
    assert noticed == []


@pytest.mark.parametrize("damage", ["bit", "cut", "empty", "text"])
def test_damaged_entries_are_noticed_and_dropped(cache, noticed, damage):
    cache.store("a stage", "key", Numbers(np.arange(1000.0), "mine"), 1.0)
    path = entry(cache)
    content = bytearray(path.read_bytes())
    if damage == "bit":
        content[len(content) // 2] ^= 1
    elif damage == "cut":
        del content[-100:]
    else:
        content = bytearray(b"" if damage == "empty" else b"not HDF5")
    path.write_bytes(content)
    assert cache.load("a stage", "key", Numbers) is None
    assert not path.exists()
    assert len(noticed) == 1
    assert str(path) in noticed[0]
    assert "computing a stage again" in noticed[0]


def test_an_entry_under_another_name_is_noticed(cache, noticed):
    """As of two cases whose files were exchanged: a fit or a run would start from the other's."""
    for key in ("aa11", "aa22"):
        cache.store("a stage", key, Numbers(np.arange(3.0), key), 1.0)
    one, other = sorted(cache.folder.rglob("*.h5"))
    between = one.with_name("between")
    digests = [path.stem.rpartition("-")[2] for path in (one, other)]
    one.rename(between)
    other.rename(other.with_name(f"a-stage-aa11-{digests[1]}.h5"))
    between.rename(one.with_name(f"a-stage-aa22-{digests[0]}.h5"))
    assert cache.load("a stage", "aa11", Numbers) is None
    assert cache.load("a stage", "aa22", Numbers) is None
    assert len(noticed) == 2
    assert all("it is the entry of another stage or study" in each for each in noticed)


def test_a_failed_store_leaves_nothing(cache, tmp_path):
    with pytest.raises(TypeError, match="cannot store"):
        cache.store("a stage", "key", Numbers(np.array([object()]), "mine"), 1.0)
    assert list(cache.folder.iterdir()) == []
    cache.folder.rmdir()
    cache.folder.write_text("in the way")
    with pytest.raises(InputError, match="cannot be written"):
        cache.store("a stage", "key", Numbers(np.zeros(1), ""), 1.0)


def test_keys_follow_inputs_and_what_is_upstream():
    base = ("s", "rom", {"a": 1, "b": [0.1, 2]}, ("up",))
    same = (
        (*base[:2], {"b": (0.1, 2), "a": 1}, ("up",)),
        (*base[:2], {"a": 1, "b": [0.1 + 1e-16, 2]}, ("up",)),
    )
    assert {key_of(*each) for each in same} == {key_of(*base)}
    others = [
        ("t", *base[1:]),
        ("s", "fem", *base[2:]),
        *(("s", "rom", {"a": 1, "b": b}, ("up",)) for b in ([0.1, 3], [0.1 + 1e-9, 2])),
        *((*base[:3], needs) for needs in (("down",), ())),
    ]
    assert len({key_of(*each) for each in (base, *others)}) == 7


def test_steps_run_once_and_only_when_needed(cache):
    calls = []

    def number(name, value, *needs):
        def compute(*given):
            calls.append(name)
            return Numbers(np.array([value + sum(g.values[0] for g in given)]), name)

        return step(name, "rom", {"value": value}, Numbers, needs, compute)

    def chain(top):
        low = number("low", 1.0)
        return number("high", top, number("middle", 10.0, low), low)

    assert Stages(cache, silent).get(chain(100.0)).values[0] == 112
    assert calls == ["low", "middle", "high"]
    assert Stages(cache, silent).get(chain(100.0)).values[0] == 112
    assert calls == ["low", "middle", "high"]  # all from the cache
    stages = Stages(cache, silent)
    assert stages.get(chain(200.0)).values[0] == 212
    assert calls == ["low", "middle", "high", "high"]
    assert [(d.stage, d.cached) for d in stages.done.values()] == [
        ("middle", True),
        ("low", True),
        ("high", False),
    ]
    entry_of_middle = next(cache.folder.rglob("middle-*.h5"))
    entry_of_middle.write_bytes(entry_of_middle.read_bytes()[:-1])
    assert Stages(cache, silent).get(chain(300.0)).values[0] == 312
    assert calls[4:] == ["middle", "high"]


def keys(text):
    """Key of each step of a one-case study."""
    return keys_of(parse_study(text))


def keys_of(study):
    (planned,) = plan(cases(study), lambda *_: None)
    found = {}
    waiting = [planned.preload, planned.response, *planned.linear.responses.values()]
    while waiting:
        one = waiting.pop()
        found[f"{one.name}, linear" if one is planned.linear.system else one.name] = one.key
        waiting += one.needs
    return found


PARTS = {f"{a} {b}" for a in ("mesh", "fem", "recovery") for b in ("vane", "casing")}
PARTS |= {"rom vane", *(f"rom casing, ND {k}" for k in range(4))}
MESHED = {f"{a} {b}" for a in ("mesh", "fem") for b in ("vane", "casing")}
CONDENSED = {"rom vane, condensed", "rom casing, condensed"}
STRUCTURE = {"structure", "mesh excess, vane", "mesh correction"}
LINEAR = {"linear response, free", "linear response, stuck"}
CASE = {"system", "preload", "response nominal"}
SYSTEM_ON = STRUCTURE | LINEAR | CASE | {"system, linear", "linear limits", "stuck modes"}
EVERYTHING = PARTS | CONDENSED | SYSTEM_ON
VANE = {each for each in EVERYTHING if " vane" in each} - STRUCTURE
CASING_ON = EVERYTHING - VANE


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ('name = "other"', set()),
        ("[outputs]\nshow = ['report']", set()),
        ("[joints.hook]\nkn = 16700000", set()),
        ("[joints.interlock]\nmu = 0.2", CASE),
        ('[joints.interlock]\ninterference = "5 um"', CASE),
        ("[joints.interlock]\nkt = 2e6", SYSTEM_ON),
        ("[excitation]\nforce = 10", SYSTEM_ON - STRUCTURE - {"stuck modes"}),
        ("[damping]\nratio = 0.001", SYSTEM_ON - STRUCTURE),
        ("[response]\nharmonics = 5", {"response nominal"}),
        ("[response]\nrange = [200, 300]", LINEAR | {"response nominal"}),
        ("[response]\nmode = 3", LINEAR | {"linear limits", "response nominal"}),
        ("[rom]\nmodes = 12", EVERYTHING - MESHED - CONDENSED),
        ("[material.casing]\nrho = 8000", CASING_ON - {"mesh casing"}),
        ('[casing]\nouter_radius = "605 mm"', CASING_ON),
        ("[vane.hook]\nband_extent = 0.91", EVERYTHING),
        ('[mesh]\nsize = "coarse"', EVERYTHING),
    ],
)
def test_a_change_reaches_exactly_what_depends_on_it(text, changed):
    before, after = keys(""), keys(text)
    assert before.keys() == EVERYTHING
    assert {name for name in before if before[name] != after[name]} == changed


ANSWERED = {"seed"} | {
    f"material.{part}.{key}"
    for part in ("vane", "casing")
    for key in ("fatigue_limit", "tensile_strength")
}
"""Numbers that only what is drawn, or the report's margins, depend on."""


def test_every_number_of_a_study_is_in_some_key():
    """A number that no key holds would be changed without a word, and old results shown."""
    study = parse_study(
        "[response]\nrange = [240, 300]\npoints = 31\nsamples = 64\n"
        "[temperature]\nvane = 610\ncasing = 600\n"
        "[material.vane]\nexpansion = 1.3e-5\n[material.casing]\nexpansion = 1.2e-5\n"
    )
    before, tried = keys_of(study), 0
    for key, value in leaves(study.model_dump()):
        if isinstance(value, bool) or not isinstance(value, int | float):
            continue
        if key in ANSWERED:
            continue
        other = other_number(study, key, value)
        assert keys_of(other) != before, key
        tried += 1
    assert tried > 50


def other_number(study, key, value):
    """The study with another number in a key, one that its neighbours allow."""
    whole = isinstance(value, int)
    for change in (1, 2, -1) if whole else (1e-3, -1e-3, 1e-2):
        changed = value + change * (1 if whole else abs(value) or 1.0)
        try:
            return with_values(study, {key: changed})
        except ValueError:
            continue
    raise AssertionError(f"{key}: no other value is allowed beside {value}")


def test_a_response_is_known_by_what_it_depends_on_and_not_by_its_case():
    """A swept key of which one value is the study's own adds nothing to compute for that value."""
    alone = plan(cases(parse_study("")), lambda *_: None)[0]
    swept = cases(parse_study('[sweep]\n"joints.interlock.mu" = [0.3, 0.5]\n'))
    same, other = plan(swept, lambda *_: None)
    assert value_at(alone.case.study, "joints.interlock.mu") == 0.3
    assert {step.key for step in reachable(steps_of(same))} == {
        step.key for step in reachable(steps_of(alone))
    }
    assert same.response.name == "response mu=0.3"
    assert other.response.key != same.response.key
