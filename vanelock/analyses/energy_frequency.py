"""Energy-frequency diagram: natural frequency and damping ratio of damped modes against energy.

The energy of the vibration of a sector is U = Σ_h ½ (hω)² x_hᴴ M x_h, which no choice of an output
changes; of a nonlinear mode it is the usual abscissa (G. Kerschen et al., Nonlinear normal modes,
Part I, Mech. Syst. Signal Process. 23 (2009) 170-194). Modes are those of `damped_modes`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from vanelock import render
from vanelock.analyses import damped_modes
from vanelock.analyses.analysis import Analysis, AnalysisPart, products_of
from vanelock.common.arrays import Floats
from vanelock.common.tables import Cell, Column, Table, by_case
from vanelock.input.cases.names import of_case, slug

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, RunResult, SolvedCase
    from vanelock.report import Picture

TEXT = (
    "Each mode is followed from contacts that stick to gross slip, as damped modes are. Its energy "
    "is that of the vibration of one sector: the sum of kinetic and strain energy of a travelling "
    "wave, the largest kinetic energy of a standing one."
)


@dataclass(frozen=True)
class EnergyFrequency(damped_modes.NumberedMode):
    """A mode at p energies; at none where it was not followed.

    Attributes
    ----------
    energy : (p,) float
        Of the vibration of one sector, J.
    frequency : (p,) float
        Hz.
    damping_ratio : (p,) float
        Of structure and friction.
    """

    energy: Floats = field(default_factory=lambda: np.empty(0), metadata={"unit": "J"})
    frequency: Floats = field(default_factory=lambda: np.empty(0), metadata={"unit": "Hz"})
    damping_ratio: Floats = field(default_factory=lambda: np.empty(0))


def _compute(
    case: "SolvedCase", keys: damped_modes.ModeKeys, part: AnalysisPart
) -> EnergyFrequency:
    """One mode of one nodal diameter, as it was followed."""
    from vanelock.quantities.contacts import balance

    place = list(damped_modes.parts(case.problem, keys)).index(part)
    followed: damped_modes.FollowedMode = case.product("damped_modes", place)
    number, k, mode = followed.number, followed.nodal_diameter, followed.mode
    if mode is None:
        return EnergyFrequency(number, k)
    at = mode.response.harmonic_diameters.tolist()
    system = case.system_at(at)
    points = range(len(mode.frequency))
    energy = np.array([balance(system, mode.response, point).stored for point in points])
    return EnergyFrequency(number, k, energy, mode.frequency, mode.damping_ratio)


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Each mode at rest, where it damps most, and as far as it was followed."""
    known, count = products_of(cases, "energy_frequency")
    columns = (
        *damped_modes.HEADS,
        *(
            Column(head, unit, form, f"{of}_{key}")
            for of, words in (("least", "least"), ("most", "most damping"), ("end", "last"))
            for head, unit, form, key in (
                (f"{words}, energy", "J", ".3g", "j"),
                ("at", "Hz", ".6g", "hz"),
                ("damping", "%", ".3g", "damping"),
            )
        ),
    )
    rows: list[tuple[Cell, ...]] = []
    for name, modes in known.items():
        for each in (mode for mode in modes if len(mode.energy)):
            columns_of = np.column_stack((each.energy, each.frequency, each.damping_ratio))
            shown = columns_of[[0, int(each.damping_ratio.argmax()), -1]].ravel().tolist()
            rows.append((name, *each.cells, *shown))
    notes = ["energy: of the vibration of one sector"]
    title = "Natural frequency and damping ratio against energy"
    yield from by_case(Table(title, columns, rows, notes, "energy_frequency"), count)


def _pictures(run: "RunResult", case: "CaseResult") -> "Iterator[Picture]":
    """The diagram, with the damping ratio below."""
    modes = [each for each in case.found("energy_frequency") if len(each.energy)]
    if not modes:
        return
    title = f"Energy-frequency diagram{of_case(case.name)}"
    subtitle = f"vibration of one sector; {modes[0].name if len(modes) == 1 else 'damped modes'}"
    panels = [
        render.CurvePanel(
            "frequency (Hz)", [render.PanelCurve(m.name, m.energy, m.frequency) for m in modes]
        ),
        render.CurvePanel(
            "damping ratio (%)",
            [render.PanelCurve(m.name, m.energy, 100 * m.damping_ratio) for m in modes],
            from_zero=True,
        ),
    ]
    counts = [len(each.energy) for each in modes]
    yield run.picture(
        f"figures/energy_frequency_{slug(case.name)}",
        "Energy-frequency diagram",
        [*case.key_of("energy_frequency"), title],
        lambda path: render.panels_picture(
            path, panels, "energy (J)", title, subtitle, logarithmic=True
        ),
        lambda: {
            **damped_modes.mode_columns(modes, counts),
            "energy (J)": np.concatenate([each.energy for each in modes]),
            "frequency (Hz)": np.concatenate([each.frequency for each in modes]),
            "damping ratio (%)": np.concatenate([100 * each.damping_ratio for each in modes]),
        },
        [title],
        f"Natural frequency and damping ratio{of_case(case.name)} against the energy of the "
        "vibration of one sector, from contacts that stick to gross slip. Where the frequency "
        "falls contacts slide; two modes that come close to each other may interact there.",
    )


ENERGY_FREQUENCY = Analysis(
    key="energy_frequency",
    title="energy-frequency diagram",
    table="damped_modes",
    keys=damped_modes.ModeKeys,
    product=lambda: EnergyFrequency,
    compute=_compute,
    parts=damped_modes.parts,
    whole_ring=lambda problem, keys: keys.nodal_diameters is not None,
    after=("damped_modes",),
    places=lambda product: f"energy_frequency/{product.place}",
    tables=_tables,
    pictures=_pictures,
    text=TEXT,
)
