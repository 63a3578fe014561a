"""A case as tables, pictures and the page see it: what is stored of it, and what follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.process import latest
from vanelock.input.cases.values import Problem
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import Audit, Response
from vanelock.quantities.contacts import EnergyBalance, Wear, balance, bandwidth_ratio, wear
from vanelock.quantities.products import Curves, Drawn, Products
from vanelock.quantities.sensitivities import Sensitivities
from vanelock.quantities.stress.fields import ModeShapes, NodalFields
from vanelock.quantities.stress.locations import SurfaceLocations, locations_of
from vanelock.quantities.stress.margins import Margins, margins
from vanelock.rom import System
from vanelock.stages.accuracy.errors import Errors, LeftOut
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.outputs import Gauges, Places, Strain, places
from vanelock.stages.response.limits import LIMITS, Limits
from vanelock.stages.response.responses import Monitor, as_solved
from vanelock.stages.response.summary import Peak, Summary

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis

_MESHES = 2
"""Of so many meshes the places of nodes are remembered."""
Numbers: TypeAlias = Mapping[str, tuple[float | str | list[float], str]]


class State(NamedTuple):
    """Another state of a case: the vibration there, of one point, its peak and its curve."""

    response: Response
    peak: Peak
    curve: Drawn


@dataclass(frozen=True, eq=False)
class CaseResult:
    """What is known of a case; products are read when they are asked for.

    Attributes
    ----------
    name : str
    values : dict of str to number or str
        The swept keys.
    problem : Study or Scene
        What its file says, as computed.
    monitor : Monitor
        The displacement in the curves.
    products : Products
        What is stored of it.
    summary : Summary
        The case in numbers.
    analyses : sequence of Analysis
        All that there are.
    components : tuple of str
        Names of its components.
    ring : (int, int)
        Number of sectors N, and engine order.
    linear_name, preload_name : str
        The swept values that distinguish its linear limits, and its preload, from other cases'.
    errors : (Errors, list of LeftOut) or None
        Estimated errors, with an accuracy.
    numbers : dict of str to (number, text or list, unit)
        At its peak, where they are known.
    detailed : bool
        Whether it is looked into: its stresses, wear and what moves its peak.
    state : State or None
        At which of its states it is looked at, in place of its peak; its place.
    """

    name: str
    values: Mapping[str, float | str]
    problem: Problem
    monitor: Monitor
    products: Products
    summary: Summary
    analyses: "Sequence[Analysis[Any, Any]]" = ()
    components: tuple[str, ...] = ()
    ring: tuple[int, int] = (1, 0)
    linear_name: str = ""
    preload_name: str = ""
    errors: tuple[Errors, Sequence[LeftOut]] | None = None
    numbers: Numbers = field(default_factory=dict)
    detailed: bool = False
    state: tuple[str, State] | None = None

    @property
    def study(self) -> Study:
        """What is given, where only a study has what is asked."""
        assert isinstance(self.problem, Study)
        return self.problem

    @property
    def peak(self) -> Peak | None:
        """Its largest point; None where none converged."""
        return self.summary.peak if self.state is None else self.state[1].peak

    @property
    def at_peak(self) -> Peak:
        """Its largest point, where there is one."""
        assert self.peak is not None
        return self.peak

    def key_at(self, path: str) -> str:
        """Hash of all that a product depends on, by its place."""
        return self.products.key(path)

    @property
    def response(self) -> Response:
        """Its response, that with the higher peak."""
        return cast(Response, self.products.get("response"))

    @property
    def responses(self) -> list[Response]:
        """Its responses, that with the higher peak first."""
        return [self.products.get(each) for each in ("response", "lower") if each in self.products]

    @property
    def static(self) -> Response:
        """Its state at rest."""
        return cast(Response, self.products.get("preload"))

    @property
    def system(self) -> System:
        """Its system."""
        return cast(System, self.products.get("system"))

    @property
    def limits(self) -> Limits:
        """Its linear modes."""
        return cast(Limits, self.products.get("limits"))

    @property
    def has_meshes(self) -> bool:
        """Whether its parts have meshes; matrices have none."""
        return "mesh/vane" in self.products

    @property
    def parts(self) -> list[Part]:
        """Vane segment and casing sector."""
        return [self.products.get(f"mesh/{part}") for part in PARTS]

    def component(self, name: str) -> Any:
        """A reduced part or component at the nodal diameter of the load."""
        return self.products.get(self._component(name))

    def _component(self, name: str) -> str:
        return f"{'rom' if self.has_meshes else 'component'}/{name}"

    @property
    def mesh_keys(self) -> list[str]:
        """Hashes of its meshes."""
        return [self.key_at(f"mesh/{part}") for part in PARTS]

    @property
    def component_keys(self) -> list[str]:
        """Hashes of its parts or components at the nodal diameter of the load."""
        return [self.key_at(self._component(name)) for name in self.components]

    @property
    def gauges(self) -> Gauges | None:
        """Its strain gauges."""
        return self.products.get("gauges") if "gauges" in self.products else None

    @property
    def strain(self) -> Strain | None:
        """What they read in its response."""
        if (gauges := self.gauges) is None:
            return None
        return self.products.once("strain", lambda: gauges.read(self.response, self.system))

    # Curves.

    @property
    def _curves(self) -> Curves:
        return cast(Curves, self.products.get("curves"))

    @property
    def curves(self) -> dict[str, Drawn]:
        """Its responses by direction, "" where there is but one; the higher one first."""
        own = self._curves
        return {name: _as_drawn(own.curve[i]) for i, name in enumerate(own.names)}

    @property
    def ends(self) -> tuple[Drawn, ...]:
        """Curves between which it may lie."""
        return tuple(map(_as_drawn, self._curves.ends.values()))

    @property
    def verdicts(self) -> dict[str, Integers]:
        """Of the points of each curve, STABLE, UNSTABLE, UNDECIDED, or -1 for not known."""
        return {self._curves.names[i]: each for i, each in self._curves.verdict.items()}

    @property
    def drawn(self) -> Drawn:
        """The curve of the first of its responses, or of the state."""
        return next(iter(self.curves.values())) if self.state is None else self.state[1].curve

    @property
    def line(self) -> tuple[Floats, Floats]:
        """The same with frequencies ascending, and NaN where a point did not converge."""
        frequency, amplitude, converged = self.drawn
        order = np.argsort(frequency, kind="stable")
        return frequency[order], np.where(converged, amplitude, np.nan)[order]

    def curve(self, response: Response) -> Drawn:
        """Frequencies, amplitudes and whether they converged, of a response."""
        return response.frequency, self.monitor.amplitude(response), response.converged

    # Analyses.

    def key_of(self, *analyses: str) -> list[str]:
        """Hashes of what analyses have found."""
        of = self.products.of_analysis
        return [self.key_at(place) for each in analyses for place in of(each)]

    @property
    def solved_keys(self) -> list[str]:
        """Hashes of its responses, and of what all analyses have found."""
        solved = [self.key_at(e) for e in ("response", "lower") if e in self.products]
        return [*solved, *self.key_of(*(each.key for each in self.analyses))]

    @property
    def linear_key(self) -> str:
        """Hash of its linear limits."""
        return " ".join(map(self.key_at, LIMITS))

    def found(self, analysis: str) -> list[Any]:
        """Products of an analysis by its key; none where it is not asked for."""
        return [self.products.get(each) for each in self.products.of_analysis(analysis)]

    def states(self, analysis: "Analysis[Any, Any]") -> "list[CaseResult]":
        """The case at the states that an analysis leads to."""

        def made() -> list[State]:
            found = list(analysis.states(self)) if self.products.of_analysis(analysis.key) else []
            for i, state in enumerate(found if self.has_meshes else ()):
                place = f"{analysis.key}/{i}/fields"
                self.products.expect(place, state.response, analysis.key)
            return found

        states = enumerate(self.products.once(f"states of {analysis.key}", made))
        return [replace(self, state=(f"{analysis.key}/{i}/", each)) for i, each in states]

    @property
    def last_states(self) -> "list[CaseResult]":
        """The last of the states that each analysis leads to."""
        return [states[-1] for each in self.analyses if (states := self.states(each))]

    # At the peak, or at a state.

    def _at(self, path: str) -> str:
        return path if self.state is None else self.state[0] + path

    @property
    def key(self) -> str:
        """Hash of what its stresses depend on, the response included."""
        return self.products.key(self._at("fields") if self.has_meshes else "response")

    @property
    def top(self) -> Response:
        """The largest point alone."""
        if self.state is not None:
            return self.state[1].response
        return self.products.once("top", lambda: as_solved(self.response, self.at_peak.point))

    @property
    def fields(self) -> NodalFields:
        """Stress cycles and displacement of all nodes."""
        return cast(NodalFields, self.products.get(self._at("fields")))

    @property
    def mode_shapes(self) -> ModeShapes:
        """The mode of interest."""
        return cast(ModeShapes, self.products.get("mode_shapes"))

    @property
    def locations(self) -> dict[str, SurfaceLocations]:
        """Places of each part's nodes, in words."""

        def made() -> dict[str, SurfaceLocations]:
            return {part.name: locations_of(self.study, part) for part in self.parts}

        known = self.products.shared.setdefault("locations", {})
        return latest(known, " ".join(self.mesh_keys), made, _MESHES)

    @property
    def margins(self) -> Margins | None:
        """Of its stresses; None where parts are matrices, which have no field."""
        if not self.has_meshes:
            return None
        gauges = () if (known := self.gauges) is None else known.names

        def made() -> Margins:
            return margins(self.study, self.fields, self.locations, gauges)

        return self.products.once(self._at("margins"), made)

    @property
    def stress(self) -> Margins:
        """The margins of a case that has stresses."""
        assert self.margins is not None
        return self.margins

    @property
    def places(self) -> Places:
        """Its contacts."""
        vane = self.products.get("mesh/vane") if self.has_meshes else None
        return self.products.once(
            "places", lambda: places(self.problem, self.system.contacts, vane)
        )

    @property
    def wear(self) -> Wear:
        """Wear indicators of the contacts."""
        area, coefficient = self.places.area, self.places.coefficient
        return self.products.once(self._at("indicators"), lambda: wear(self.top, area, coefficient))

    @property
    def balance(self) -> EnergyBalance:
        """Where the energy of the vibration goes."""
        return self.products.once(self._at("energy"), lambda: balance(self.system, self.top))

    @property
    def bandwidth(self) -> float:
        """Damping ratio by the half-power bandwidth; NaN where the curve is too short."""
        return bandwidth_ratio(*self.line)

    @property
    def audit(self) -> Audit | None:
        """The peak checked by marching; None for what an audit does not cover."""
        return self.products.get("audit") if "audit" in self.products else None

    @property
    def sensitivities(self) -> Sensitivities | None:
        """What moves the peak."""
        return self.products.get("sensitivities") if "sensitivities" in self.products else None


def _as_drawn(rows: Floats) -> Drawn:
    """A curve from its rows."""
    frequency, amplitude, converged = rows
    return frequency, amplitude, converged.astype(bool)
