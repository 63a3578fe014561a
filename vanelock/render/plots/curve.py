"""A forced response curve to be drawn: its arrays, its name, and its peak."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Final, Literal

import numpy as np

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.render import style

Kind = Literal["nonlinear", "free", "stuck", "measured"]
Dash = Literal["solid", "dash", "dot", "dashdot"]
DASHES: Final[tuple[Dash, ...]] = ("solid", "dash", "dot", "dashdot")
"""The most harmonics get the full line."""

MICROMETRES: Final = 1e6
"""What amplitudes, m, are multiplied by where they are drawn."""
AXES: Final = ("excitation frequency (Hz)", "amplitude (µm)")
LIMITS: Final = {"free": "linear, free", "stuck": "linear, stuck"}
"""What the legend calls the linear limits."""

_GREYS: Final = (style.GREY, "#1a1a1a", "#a3a3a3", "#454545", "#8a8a8a")
"""Of linear limits that no response shares its colour with, a grey for each group."""


@dataclass(frozen=True)
class MarkedPeak:
    """Largest converged point of a curve: Hz, m, and whether it lies at an end of the range."""

    frequency: float
    amplitude: float
    at_edge: bool

    @property
    def place(self) -> str:
        """Where it is, in words."""
        return f"{style.number(MICROMETRES * self.amplitude)} µm at {self.frequency:.1f} Hz"


@dataclass(frozen=True)
class Band:
    """Percentiles of many curves at the same frequencies.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    levels : (5, p) float
        5, 25, 50, 75 and 95 % of the curves are below these amplitudes, m.
    label : str
        Whose they are, such as "200 samples".
    """

    frequency: Floats
    levels: Floats
    label: str


@dataclass(frozen=True)
class Envelope:
    """Between which amplitudes a curve may lie.

    Attributes
    ----------
    frequency, low, high : (p,) float
        Hz, and the ends there, m.
    outlines : sequence of (frequency, amplitude)
        Curves that it goes round, Hz and m.
    """

    frequency: Floats
    low: Floats
    high: Floats
    outlines: Sequence[tuple[Floats, Floats]]


@dataclass(frozen=True)
class Curve:
    """Amplitude over frequency of one case.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    amplitude : (p,) float
        m; not a number where a point has none.
    group : str
        What the colour stands for, such as "μ = 0.3"; curves of one group share it.
    harmonics : int or None
        H, which the line style stands for.
    converged : (p,) bool or None
        Which points converged; None: all. The others are flagged in the figure, never left out.
    kind : "nonlinear", "free", "stuck" or "measured"
        The linear limits, with open and with closed contacts, are drawn in grey, or in the colour
        of the nonlinear curves of their group. A measured one is black dots.
    joined : bool
        Whether a line joins the points; without it they are dots, and no peak is said to lie at
        the end of a range.
    variant : str
        What the line style stands for instead of H, such as a direction of the sweep.
    envelope : Envelope or None
        Shaded in the curve's colour.
    verdict : (p,) int or None
        0 where the wave is stable, 1 unstable, 2 undecided, -1 not known: where points in a row are
        known, the line is solid, dashed, and grey.
    case : str
        What tables call its case, if it is of one.
    """

    frequency: Floats
    amplitude: Floats
    group: str = ""
    harmonics: int | None = None
    converged: Booleans | None = None
    kind: Kind = "nonlinear"
    joined: bool = True
    variant: str = ""
    envelope: Envelope | None = None
    verdict: Integers | None = None
    case: str = ""

    @property
    def label(self) -> str:
        """What the legend calls it."""
        if self.kind == "measured":
            return ": ".join(filter(None, ("measured", self.group)))
        if self.kind != "nonlinear":
            return ": ".join(filter(None, (LIMITS[self.kind], self.group)))
        harmonics = "" if self.harmonics is None else f"H = {self.harmonics}"
        return ", ".join(filter(None, (self.group, self.variant, harmonics))) or "response"

    @property
    def style(self) -> str | int:
        """What the line style stands for."""
        return self.variant or self.harmonics or 0

    @property
    def outcome(self) -> str:
        """What becomes of the wave at the peak: "stable", "unstable", "undecided", "" not known."""
        top = peak(self)
        if top is None or self.verdict is None:
            return ""
        at = self.frequency.tolist().index(top.frequency)
        return ("stable", "unstable", "undecided", "")[int(self.verdict[at])]

    @property
    def pieces(self) -> list[tuple[int, slice]]:
        """Runs of points of one verdict, neighbouring ones sharing a point; 2 between others."""
        count = len(self.frequency)
        code = np.full(count, -1) if self.verdict is None else self.verdict
        between = np.where(code[1:] == code[:-1], code[1:], np.maximum(code[1:], 2))
        unknown = (code[1:] < 0) | (code[:-1] < 0)
        between[unknown] = -1
        if not len(between):
            return [(-1, slice(0, count))]
        starts = [0, *(np.flatnonzero(np.diff(between)) + 1).tolist()]
        ends = [*starts[1:], len(between)]
        return [(int(between[a]), slice(a, b + 1)) for a, b in zip(starts, ends, strict=True)]


def peak(curve: Curve) -> MarkedPeak | None:
    """Largest converged point of a curve; None where no point converged."""
    amplitude, frequency = np.where(converged(curve), curve.amplitude, np.nan), curve.frequency
    if np.all(np.isnan(amplitude)):
        return None
    at = int(np.nanargmax(amplitude))
    ends = (frequency.min(), frequency.max())
    at_edge = curve.joined and ends[0] < ends[1] and bool(frequency[at] in ends)
    return MarkedPeak(float(frequency[at]), float(amplitude[at]), at_edge)


def converged(curve: Curve) -> Booleans:
    """(p,) points that converged and have an amplitude."""
    known: Booleans = np.isfinite(curve.amplitude)
    return known if curve.converged is None else known & curve.converged


@dataclass(frozen=True)
class CurveLook:
    """How a curve is drawn: "#rrggbb", dashes, points of width, matplotlib's marker of its peak."""

    colour: str
    dash: Dash
    width: float
    marker: str


def looks(curves: Sequence[Curve]) -> list[tuple[Curve, CurveLook]]:
    """Each curve with its colour, line style and marker."""
    groups = list(dict.fromkeys(c.group for c in curves if c.kind == "nonlinear"))
    colours = dict(zip(groups, style.series(len(groups)), strict=True))
    styles = _styles(curves)
    linear = dict.fromkeys(c.group for c in curves if c.kind in LIMITS)
    greys = dict(zip(linear, cycle(_GREYS), strict=False))
    measured = [c for c in curves if c.kind == "measured"]
    made = []
    for curve in curves:
        if curve.kind == "nonlinear":
            order = styles.index(curve.style)
            look = CurveLook(colours[curve.group], DASHES[order % 4], 2.0, "os^D"[order % 4])
        elif curve.kind == "measured":
            marker = "osD^"[next(i for i, c in enumerate(measured) if c is curve) % 4]
            look = CurveLook(style.BLACK, "solid", 0.0, marker)
        else:
            colour = (curve.group and colours.get(curve.group)) or greys[curve.group]
            look = CurveLook(colour, "dash" if curve.kind == "free" else "dot", 1.6, "v")
        made.append((curve, look))
    return made


def _styles(curves: Sequence[Curve]) -> list[str | int]:
    """What the line styles stand for, the full line first."""
    nonlinear = [curve for curve in curves if curve.kind == "nonlinear"]
    variants: list[str | int] = list(dict.fromkeys(c.variant for c in nonlinear if c.variant))
    return variants + sorted({c.harmonics or 0 for c in nonlinear if not c.variant}, reverse=True)
