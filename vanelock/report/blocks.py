"""What a report page is made of: plain data, in the order in which it is read.

Arrays arrive in the units that their labels name (µm, Hz); only bodies and motions are in m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import Complex, Floats
from vanelock.common.tables import Flag, Table

Mode = Literal["lines", "markers", "lines+markers"]


@dataclass(frozen=True)
class Text:
    """Paragraphs, parted by empty lines; **bold** and `code` are marked so, the rest is literal."""

    text: str


@dataclass(frozen=True)
class Answer:
    """One thing that the reader came for.

    Attributes
    ----------
    label : str
        What it is: "Peak amplitude".
    value : str
        Number and unit: "48.3 µm".
    note : str
        Where, at which case, how sure.
    flag : {"", "good", "warn", "bad"}
        Whether it is well; shown by a word as well as by a colour.
    """

    label: str
    value: str
    note: str = ""
    flag: Flag = ""


def withheld(title: str) -> Answer:
    """In place of an answer that a range without its peak cannot give."""
    note = "the largest point is at the end of the frequency range, and a peak may lie beyond"
    return Answer(title, "withheld", f"{note}: widen response.range", "warn")


@dataclass(frozen=True)
class Answers:
    """Answers side by side as cards."""

    items: tuple[Answer, ...]


@dataclass(frozen=True)
class Picture:
    """A PNG or GIF file, put into the page.

    Attributes
    ----------
    path : Path
        The file.
    title, caption : str
        Heading, and what is to be seen.
    data : sequence of Path or str
        Files beside the report that hold its numbers, given by name.
    case : str
        The case that it belongs to, if it does to one.
    section : str
        Identity of the section that shows it, if not that of figures.
    """

    path: Path
    title: str
    caption: str
    data: Sequence[Path | str] = ()
    case: str = ""
    section: str = ""


@dataclass(frozen=True)
class Trace:
    """One curve, or set of points, of a plot.

    Attributes
    ----------
    x, y : (n,) float
        In the plot's units; NaN breaks the line.
    name : str
        Its name in the legend.
    group : str
        Traces of one group are toggled together and share a legend entry, the first one's.
    dash : {"solid", "dash", "dot", "dashdot"}
        How the line is drawn.
    width : float
        Of the line, pixels.
    mode : {"lines", "markers", "lines+markers"}
        What is drawn.
    colour : str
        "#rrggbb"; by default the next of the house's series.
    hover : str
        More to be shown under the pointer, the same for all points.
    fill : float
        Opacity, 0 to 1, of what the line goes round, which then is shaded and not outlined.
    """

    x: Floats
    y: Floats
    name: str
    group: str = ""
    dash: Literal["solid", "dash", "dot", "dashdot"] = "solid"
    width: float = 2.0
    mode: Mode = "lines"
    colour: str = ""
    hover: str = ""
    fill: float = 0.0


@dataclass(frozen=True)
class Plot:
    """Curves to look into: hover, zoom, toggle by the legend.

    Attributes
    ----------
    traces : sequence of Trace
        The curves.
    xlabel, ylabel : str
        Quantity and unit: "frequency (Hz)".
    title, caption : str
        Heading, and what is to be seen.
    log_x, log_y : bool
        Logarithmic axes.
    data : sequence of Path or str
        Files beside the report that hold its numbers, given by name.
    y_from_zero : bool
        Begin the vertical axis at zero, unless it is logarithmic or something is negative.
    zoom : ((float, float), (float, float)), optional
        Range of x and of y around what matters most, which a button shows; another one changes the
        vertical axis between logarithmic and linear.
    """

    traces: Sequence[Trace]
    xlabel: str
    ylabel: str
    title: str
    caption: str = ""
    log_x: bool = False
    log_y: bool = False
    data: Sequence[Path | str] = ()
    y_from_zero: bool = True
    zoom: tuple[tuple[float, float], tuple[float, float]] | None = None


@dataclass(frozen=True)
class Body:
    """One sector's skin of one part.

    Attributes
    ----------
    points : (m, 3) float
        m; the engine axis is z.
    triangles : (t, 3) int
        Into `points`, counter-clockwise seen from outside.
    sectors : int
        Of the full ring; the next one is this one turned by 2π/N.
    outline : (k, 2) int
        Into `points`: edges drawn as lines.
    name : str
        Of the part: selects its colour at rest.
    """

    points: Floats
    triangles: NDArray[np.integer]
    sectors: int
    outline: NDArray[np.integer]
    name: str = ""


@dataclass(frozen=True)
class Motion:
    """How the ring moves: x_j(t) = Re(x_0 e^{i(α - j φ)}) in cylindrical components, φ = 2π ND/N.

    Attributes
    ----------
    name : str
        "Response at the peak, μ = 0.15".
    nodal_diameter : int
        Of the wave.
    shapes : tuple of (m, 3) complex
        Cartesian displacement on sector 0, one for each body. In m; or in any scale if `relative`.
    frequency : float
        Hz.
    note : str
        A line under it.
    relative : bool
        A mode: the colour bar gives the share of the largest displacement instead of µm.
    """

    name: str
    nodal_diameter: int
    shapes: tuple[Complex, ...]
    frequency: float
    note: str = ""
    relative: bool = False


@dataclass(frozen=True)
class View:
    """Bodies in motion, turned with the pointer.

    Attributes
    ----------
    bodies : sequence of Body
        Of one ring.
    motions : sequence of Motion
        To choose from; the first one is shown.
    title, caption : str
        Heading, and what is to be seen.
    """

    bodies: Sequence[Body]
    motions: Sequence[Motion]
    title: str
    caption: str = ""


Single = Text | Answers | Table | Picture | Plot | View


@dataclass(frozen=True)
class OfCase:
    """What belongs to one case: a page of several shows that of the case that its reader chose.

    Attributes
    ----------
    case : str
        The case in words; the first one of a page is chosen at first.
    blocks : sequence of blocks
    """

    case: str
    blocks: Sequence[Single]


Block = Single | OfCase


@dataclass(frozen=True)
class Section:
    """A heading of the contents list and what stands under it.

    Attributes
    ----------
    title : str
        The heading.
    blocks : sequence of blocks
        What stands under it.
    id : str
        Its name in addresses, by default made of the title.
    folded : bool
        Whether the heading alone is shown until it is clicked; on paper all is.
    """

    title: str
    blocks: Sequence[Block]
    id: str = ""
    folded: bool = False


@dataclass(frozen=True)
class Page:
    """The whole report.

    Attributes
    ----------
    title, subtitle : str
        The study's name; the date and the program's version, repeated in the footer.
    sections : sequence of Section
        In their order.
    """

    title: str
    subtitle: str
    sections: Sequence[Section]
