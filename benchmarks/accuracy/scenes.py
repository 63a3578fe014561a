"""Scenes drawn at random: designs of vane and casing, and joints, loads and damping for each.

A scene is a number; design `number // EACH` gives its geometry. The draw is of NumPy's generator
with a fixed seed, so a number is always the same scene. None is left out for being hard: some have
folds, contacts that open at every period, hooks that slip, isotropic friction, contacts on patches,
no interlock at all.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vanelock import Study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import misfits

Values = dict[str, Any]

DESIGNS, EACH = 13, 5
COUNT = DESIGNS * EACH
SEED = 20_270
SIZE = 0.025
"""Largest edge of an element, m, pinned: what remains are modes, harmonics, samples, points."""
ON_PATCHES = (4, 9)
"""Designs whose contacts act on patches."""
TRIES = 100


@dataclass(frozen=True)
class Scene:
    """One scene.

    Attributes
    ----------
    number, design : int
    kind : str
        What is special about it; "" if nothing is.
    values : dict
        The study's tables.
    """

    number: int
    design: int
    kind: str
    values: Values

    def study(self, **changes: Values) -> Study:
        """The scene as a study, some tables' keys changed; `accuracy` stands at the top."""
        found = {key: dict(table) for key, table in self.values.items()}
        found["damping"] = {"joints": "stuck", **found.get("damping", {})}  # as the references
        plain: Values = {}
        for key, change in changes.items():
            if isinstance(change, dict):
                found[key] = {**found.get(key, {}), **change}
            else:
                plain[key] = change
        return Study.model_validate({**found, **plain})


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is evenly distributed."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def design(number: int) -> Values:
    """Tables `ring`, `vane`, `casing` and `mesh` of a design, the first draw that fits."""
    random = np.random.default_rng([SEED, number])
    for _ in range(TRIES):
        found = drawn_design(random)
        try:
            wrong = misfits(Study.model_validate(found))
        except ValueError:
            continue
        if not wrong:
            return found
    raise InputError(f"design {number}: none of {TRIES} draws fits")


def drawn_design(random: np.random.Generator) -> Values:
    """A design that may contradict itself."""
    shift = float(random.uniform(-0.015, 0.015))
    thickness = float(random.uniform(3.8e-3, 5.5e-3))
    aerofoils, sectors = int(random.choice([3, 4])), int(random.integers(12, 21))
    outer = 0.6 + float(random.uniform(3.4e-3, 5.5e-3))
    vane = {
        "aerofoils": aerofoils,
        "chord": float(random.uniform(0.040, 0.050)),
        "thickness": thickness,
        "edge_thickness": 0.5 * thickness,
        "camber": float(random.uniform(0.05, 0.16)),
        "stagger": float(random.uniform(25, 45)),
        "twist": float(random.choice([0.0, random.uniform(-6, 6)])),
        "lean": float(random.choice([0.0, random.uniform(-4, 4)])),
        "inner_shroud_inner_radius": 0.410 + shift,
        "inner_shroud_outer_radius": 0.410 + shift + float(random.uniform(0.018, 0.026)),
        "interlock_slant": float(random.uniform(20, 45)),
        "interlock_nodes": int(random.choice([3, 5, 7])),
        "hook": {"band_nodes": int(random.choice([9, 15])), "band_extent": 0.9},
        "root_fillet": 0.0,
    }
    casing = {"outer_radius": outer, "force_nodes": 16}
    return {
        "ring": {"sectors": sectors},
        "vane": vane,
        "casing": casing,
        "mesh": {"size": SIZE, "stretch": 1, "correction": "none"},  # errors are those of the rest
    }


def draw(number: int) -> Scene:
    """The scene of a number, always the same."""
    of, place = divmod(number, EACH)
    random = np.random.default_rng([SEED, of, place])
    hook: Values = {
        "kn": 1.67e7 * log_uniform(random, 0.4, 2.5),
        "kt": 1.67e7 * log_uniform(random, 0.4, 2.5),
    }
    interlock: Values = {
        "kn": 1e6 * log_uniform(random, 0.4, 3.0),
        "kt": 1e6 * log_uniform(random, 0.4, 3.0),
        "mu": log_uniform(random, 0.08, 0.8),
        "interference": log_uniform(random, 0.3e-6, 8e-6),
    }
    force = log_uniform(random, 2, 60)
    order = int(random.choice([1, 1, 2, 3]))
    damping = log_uniform(random, 1e-3, 5e-3)
    coupling = {(6, 1): "uncoupled", (8, 2): "constant-load"}.get((of, place), "coupled")
    joints: Values = {"hook": hook, "interlock": interlock}
    response: Values = {"coupling": coupling}
    kinds = []
    if place == 3:
        hook["mu"] = log_uniform(random, 0.02, 0.1)
        hook["interference"] = log_uniform(random, 3e-6, 10e-6)
        kinds.append("hooks slip")
        if of % 2:
            joints["interlock"] = False
            kinds.append("no interlock")
    if place == 4:
        if of % 3 == 0:
            response["friction"] = "isotropic"
            kinds.append("isotropic")
        else:  # contacts open at every period
            force = log_uniform(random, 30, 60)
            interlock["interference"] = log_uniform(random, 0.3e-6, 1e-6)
            kinds.append("opens")
    joints["patch"] = "area" if of in ON_PATCHES else "node"
    if of in ON_PATCHES:
        kinds.append("patches")
    if coupling != "coupled":
        kinds.append(coupling)
    values = {
        **design(of),
        "joints": joints,
        "excitation": {"engine_order": order, "force": force},
        "damping": {"ratio": damping},
        "response": response,
    }
    return Scene(number, of, ", ".join(kinds), values)
