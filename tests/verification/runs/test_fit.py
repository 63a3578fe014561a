"""Fits to curves that the program made itself, with scatter, from this model and from others.

On the coarsest mesh at full count; on a yet coarser one with fewer contacts else, whose joints are
as stiff as a whole, with fewer seeds and harmonics.
"""

from tests.conftest import FULL

from functools import lru_cache

import numpy as np
import pytest
from scipy.stats import binom

from tests.verification.vane import DIMENSIONS, HOOK, JOINTS, SIZE
from vanelock import parse_study
from vanelock.commands.fit.least_squares import fit
from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.fit.refit_model import rejoined
from vanelock.commands.fit.solution import LEVEL
from vanelock.commands.fit.tables import doubts
from vanelock.input.measured.curve import Measured
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages

HARMONICS = 3 if FULL else 1
MU, KT = "joints.interlock.mu", "joints.interlock.kt"
VANE, CASING = "material.vane.E", "material.casing.E"
TRUTH = {MU: 0.22, KT: 1.4e6 if FULL else 2.3e6}
FAR = {MU: 0.4, KT: 1e6 if FULL else JOINTS[1].kt}
MESH, FINER = ("coarse", "18 mm") if FULL else (f"{1e3 * SIZE:g} mm", "34 mm")
HERTZ = np.linspace(250, 277, 31) if FULL else np.linspace(264, 291, 16)
LESS = f"""[vane]
interlock_nodes = {DIMENSIONS.interlock_nodes}
root_fillet = {DIMENSIONS.root_fillet}
[vane.hook]
band_nodes = {HOOK.band_nodes}
[joints.hook]
kn = {JOINTS[0].kn}
kt = {JOINTS[0].kt}
[joints.interlock]
kn = {JOINTS[1].kn}
"""
SCATTER = 0.02
"""Standard deviation, of the largest amplitude."""


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """Function that reduces the scene with a mesh and a number of harmonics."""
    stages = Stages(Cache(tmp_path_factory.mktemp("fit"), print), lambda event: None)

    @lru_cache
    def build(size=MESH, harmonics=HARMONICS):
        text = (
            f'[mesh]\nsize = "{size}"\ncorrection = "none"\n[response]\nharmonics = {harmonics}\n'
        )
        return rejoined(parse_study(text if FULL else text + LESS), stages)

    return build


def curve(model, hertz):
    """The true curve of a model."""
    return model.amplitudes(TRUTH, Measured("rig", hertz, hertz))


def fitted(model, hertz, true, seed, starts, given=True, by_slopes=True, **fixed):
    """A fit to a curve with scatter of a seed, given or not, from the starts given by key.

    By slopes or by differences.
    """
    sigma = np.full(len(true), SCATTER * true.max())
    data = true + sigma * np.random.default_rng(seed).standard_normal(len(true))
    parameters = [
        FitParameter(
            key,
            start,
            start / (1.4 if key.endswith("E") else 10),
            start * (1.4 if key.endswith("E") else 10),
        )
        for key, start in starts.items()
    ]
    rig = Measured("rig", hertz, data)

    def predict(values):
        return model.amplitudes(fixed | dict(zip(starts, values.tolist(), strict=True)), rig)

    def slopes(values):
        chosen = fixed | dict(zip(starts, values.tolist(), strict=True))
        return model.slopes(chosen, list(starts), rig)

    sizes = sigma if given else np.ones(len(data))
    return fit(predict, data, sizes, parameters, 1, given, slopes=slopes if by_slopes else None)


@pytest.fixture(scope="module")
def refitted(model):
    """Function that fits the truth's curve from the truth on, once for each seed."""
    true = curve(model(), HERTZ)
    return lru_cache(lambda seed, given: fitted(model(), HERTZ, true, seed, TRUTH, given=given))


def off(found):
    """(p,) distances of the fitted values from the true ones, in their standard errors."""
    x = [np.log(v / TRUTH[p.key]) for p, v in zip(found.parameters, found.value, strict=True)]
    return np.array(x) / found.deviation


@pytest.mark.parametrize("given", [True, False], ids=["sigma", "no sigma"])
def test_intervals_of_95_percent_hold_the_truth(refitted, given, record):
    """Of 24 seeds with sigma and of 24 others without: those of two standard errors, as printed.

    No more have their errors withheld than the level of the tests, no fewer intervals hold the
    truth than one time in a hundred by chance.
    """
    count = 24 if FULL else 2
    seeds = range(count) if given else range(count, 2 * count)
    fits = [refitted(seed, given) for seed in seeds]
    ends = np.array([[found.interval(i) for i in range(len(TRUTH))] for found in fits])
    truth = np.array(list(TRUTH.values()))
    held = ((ends[:, :, 0] < truth) & (truth < ends[:, :, 1])).sum(axis=0)
    withheld = sum(not found.carried for found in fits)
    rises = np.array([rise for found in fits for each in found.rises for rise in each])
    distances = np.array([off(found) for found in fits])
    spread = np.sqrt((distances**2).mean(axis=0))
    record("seeds", f"{seeds[0]} to {seeds[-1]}")
    record("errors withheld", f"{withheld} of {count}")
    record("rise at one standard error", f"{rises.min():.2f} to {rises.max():.2f}")
    record("95 % intervals that hold the truth", f"mu {held[0]}, kt {held[1]} of {count}")
    record("rms distance", f"mu {spread[0]:.2f}, kt {spread[1]:.2f} standard errors")
    assert withheld <= binom.ppf(0.99, count, LEVEL)
    assert held.min() >= binom.ppf(0.01, count, 0.95)
    assert np.abs(distances).max() < 4


def test_slopes_take_a_third_of_the_responses_of_differences(model, refitted, record):
    """Of the search for the best fit; the check of its errors takes as many of both."""
    seeds, true, searches = 3 if FULL else 2, curve(model(), HERTZ), []
    for seed in range(seeds):
        other = fitted(model(), HERTZ, true, seed, TRUTH, by_slopes=False)
        pair = [refitted(seed, True), other]
        searches.append([found.starts[0].evaluations for found in pair])
        assert np.all(np.abs(np.log(pair[0].value / pair[1].value)) < 0.02 * pair[0].deviation)
    by_slopes, by_differences = np.sum(searches, axis=0)
    record("seeds", str(seeds))
    record(
        "responses of the search", f"{by_slopes} by slopes, {by_differences} by differences"
    )
    assert 3 * by_slopes <= by_differences


def test_a_far_start_finds_the_truth_of_a_model_with_more_harmonics(model, record):
    """Data with five harmonics, fit with three: what they miss is less than the scatter.

    With three and two in a quick run.
    """
    seeds, hertz = (3, HERTZ) if FULL else (2, HERTZ[::2])
    more, fewer = (5, 3) if FULL else (3, 2)
    true, few = curve(model(harmonics=more), hertz), model(harmonics=fewer)
    distances = [off(fitted(few, hertz, true, seed, FAR)) for seed in range(seeds)]
    record("seeds", str(seeds))
    worst = np.abs(distances).max(axis=0)
    record("largest distance", f"mu {worst[0]:.2f}, kt {worst[1]:.2f} standard errors")
    assert np.max(worst) < 3


def test_another_mesh_takes_its_moduli_along(model, record):
    """Data of a finer mesh, whose frequencies are 1 % lower.

    Friction alone cannot make up for that, and says so without any sigma; with both moduli it is
    found.
    """
    hertz = np.linspace(247, 274, 41) if FULL else HERTZ[::2] - 3
    true = curve(model(FINER, 5 if FULL else 3), hertz)
    fixed = {KT: TRUTH[KT]}
    alone = fitted(model(), hertz, true, 0, {MU: 0.4}, given=False, **fixed)
    assert any("THE MODEL MISSES THE DATA" in text for text in doubts(alone))
    record(
        "misfit by mu alone", f"{alone.after / (SCATTER * true.max()):.1f} standard deviations"
    )
    seeds, distances = (3 if FULL else 2), []
    for seed in range(seeds):
        found = fitted(model(), hertz, true, seed, {MU: 0.4, VANE: 1.7e11, CASING: 1.7e11}, **fixed)
        assert found.after < 1.5
        distances.append(np.log(found.value[0] / TRUTH[MU]) / found.deviation[0])
    record("with both moduli", f"{found.after:.2f} standard deviations")
    record(
        "mu off by", ", ".join(f"{each:+.1f}" for each in distances) + " standard errors"
    )
    assert np.abs(distances).max() < 3
