"""The cases behind each figure of the published study, around one scene.

A sheet is a figure's cases; cases that several figures share are computed once. Figures are
numbered as by Lassalle and Firrone in their study of a stator vane segment with friction joints.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from vanelock.common.errors import InputError
from vanelock.input.cases.names import quantity, valued
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import value_at, with_values
from vanelock.input.schema.study import Study
from vanelock.input.settings import unit_of

MU = "joints.interlock.mu"
INTERFERENCE = "joints.interlock.interference"
HARMONICS = "response.harmonics"
COUPLING = "response.coupling"
DIAMETERS = "response.harmonic_diameters"
FORCE = "excitation.force"
UNBALANCE = "excitation.unbalance"
KEYS = (MU, INTERFERENCE, HARMONICS, COUPLING, DIAMETERS, FORCE, UNBALANCE)

COUPLINGS = ("coupled", "uncoupled", "constant-load")
GAP = -1e-3
"""Interference of an interlock that never touches, m: it keeps the masters and the damping of one
that does, so that the responses compare."""

Changes = Mapping[str, Any]


@dataclass(frozen=True)
class Sheet:
    """The cases of one figure.

    Attributes
    ----------
    name : str
        Short, for files: "friction".
    figure : str
        The figure of the published study.
    title : str
    cases : tuple of str
        Names of its cases, in the order in which they are drawn.
    """

    name: str
    figure: str
    title: str
    cases: tuple[str, ...]


@dataclass(frozen=True)
class Plan:
    """All sheets and the cases that they share.

    Attributes
    ----------
    base : Study
        The scene at the reference friction, one harmonic, coupled.
    sheets : dict of str to Sheet
        By name.
    cases : dict of str to Case
        By name.
    """

    base: Study
    sheets: dict[str, Sheet]
    cases: dict[str, Case]

    def study(self, case: str) -> Study:
        """A case's study."""
        return self.cases[case].study


def base_study(study: Study) -> Study:
    """The scene that a campaign starts from: reference friction, one harmonic, coupled.

    Raises
    ------
    InputError
        If its interlock does not touch at rest.
    """
    assert study.campaign is not None
    pressed = study.joints.interlock.interference
    if not pressed > 0:  # refused here: the campaign's own case of the hooks alone has a gap
        raise InputError(f"{INTERFERENCE} = {pressed:g}: must be > 0 m in a campaign")
    start = {MU: study.campaign.reference_mu, HARMONICS: 1, COUPLING: COUPLINGS[0]}
    if study.response.harmonic_diameters != "wave":
        start[DIAMETERS] = "wave"
    if study.excitation.unbalance is None:
        start[FORCE] = study.excitation.force_per_node  # a default would not be listed
    return with_values(study, start)


def planned_sheets(study: Study, small: float) -> Plan:
    """Cases of every figure.

    Parameters
    ----------
    study : Study
        With a campaign.
    small : float
        Factor of the load at which every contact sticks.
    """
    campaign = study.campaign
    assert campaign is not None
    base = base_study(study)
    book = _Sheets(base)
    loaded = UNBALANCE if base.excitation.unbalance is not None else FORCE
    load = load_of(base)
    largest = campaign.mu[-1]
    few = [{HARMONICS: h} for h in campaign.harmonics]
    same = [{HARMONICS: h, DIAMETERS: "sector"} for h in campaign.harmonics if h > 1]
    book.add("hooks", "10", "hooks in friction, interlock apart", [{INTERFERENCE: GAP}])
    stuck = [{COUPLING: each, loaded: small * load} for each in COUPLINGS]
    book.add("stuck", "11", "hooks and interlock stuck", stuck)
    friction = [{MU: mu, COUPLING: each} for mu in campaign.mu for each in COUPLINGS]
    book.add("friction", "12, 15", "friction coefficient", friction)
    book.add("harmonics", "13", "number of harmonics", [*few, *same])
    pressed = [
        {MU: largest, INTERFERENCE: value, COUPLING: each}
        for value in campaign.interference
        for each in COUPLINGS
    ]
    book.add("interference", "14, 16", "interlock interference", pressed)
    return with_one_bounded(book.plan())


def with_one_bounded(plan: Plan) -> Plan:
    """The same with bounds over static friction, if asked for, of the main case alone."""
    main = main_case(plan)
    cases = {
        name: case
        if name == main
        else replace(case, given=case.study.model_copy(update={"bounds": None}))
        for name, case in plan.cases.items()
    }
    return replace(plan, cases=cases)


def main_case(plan: Plan) -> str:
    """The case that stands for the scene: reference friction, the most harmonics."""
    campaign = plan.base.campaign
    assert campaign is not None
    return case_of(plan, harmonics=max(campaign.harmonics))


def load_of(study: Study) -> float:
    """The load: force per node, N, or unbalance, kg m."""
    return study.excitation.unbalance or study.excitation.force_per_node


class _Sheets:
    """Sheets as they are written; a case is known by what it changes of the base."""

    def __init__(self, base: Study) -> None:
        self._base = base
        self._sheets: dict[str, Sheet] = {}
        self._studies: dict[str, Study] = {}

    def add(self, name: str, figure: str, title: str, changes: Iterable[Changes]) -> None:
        """Add a sheet with a case for each set of changed keys."""
        names = [self._case(each) for each in changes]
        self._sheets[name] = Sheet(name, figure, title, tuple(names))

    def _case(self, changes: Changes) -> str:
        differing = {k: v for k, v in changes.items() if v != value_at(self._base, k)}
        name = case_name(differing)
        if name not in self._studies:
            self._studies[name] = with_values(self._base, differing)
        return name

    def plan(self) -> Plan:
        """All of it; every case has the same keys, so that cases can be told apart by them."""
        used = [
            key
            for key in KEYS
            if len({value_at(study, key) for study in self._studies.values()}) > 1
        ]
        first = case_name({})
        cases = {
            name: Case(
                name,
                {key: value_at(study, key) for key in used},
                study if name == first else study.model_copy(update={"campbell": None}),
            )
            for name, study in self._studies.items()
        }
        return Plan(self._base, self._sheets, cases)


def case_name(changes: Changes) -> str:
    """A case's name from what it changes, such as "mu=0.1,coupling=uncoupled"."""
    texts = []
    for key in KEYS:
        if key in changes:
            texts.append(f"{key.rpartition('.')[2]}={valued(changes[key], unit_of(key))}")
    return ",".join(texts) or "reference"


def case_words(name: str) -> str:
    """A case's name as people write it: "μ = 0.5, 1 µm, uncoupled"."""
    texts = []
    for text in name.split(","):
        key, _, value = text.partition("=")
        if key == "interference":
            apart = value == valued(GAP, "m")
            texts.append("interlock apart" if apart else quantity(value))
        elif key == "harmonic_diameters":
            texts.append("one diameter")
        elif key == "coupling":
            texts.append(value)
        elif value:
            symbol = {"mu": "μ", "harmonics": "H"}.get(key, key)
            texts.append(f"{symbol} = {value}")
        else:
            texts.append(text)
    return ", ".join(texts)


def case_of(plan: Plan, **wanted: Any) -> str:
    """Name of the base's case with some of mu, interference, harmonics, coupling, diameters."""
    keys = {
        "mu": MU,
        "interference": INTERFERENCE,
        "harmonics": HARMONICS,
        "coupling": COUPLING,
        "diameters": DIAMETERS,
    }
    changed = {keys[name]: value for name, value in wanted.items()}
    return case_name({k: v for k, v in changed.items() if v != value_at(plan.base, k)})
