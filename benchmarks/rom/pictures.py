"""Pictures of the errors of reduced models."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from benchmarks.rom.reduced import EVERY, Bench, Outcome, Setting
from vanelock.render import style

Floats = NDArray[np.float64]
Found = list[tuple[Setting, Outcome]]
COLOURS = {"published": style.VERMILION, "followed": style.GREEN}
FLOOR = 1e-10


def errors(
    found: Found,
    unit: float,
    frequencies: tuple[Floats, Floats],
    response: tuple[Floats, Floats],
    path: Path,
) -> None:
    """Errors against coordinates and cost, and estimates against true errors."""
    with style.applied():
        figure = style.figure(
            11.2,
            "Reduced models against the unreduced sector",
            "nodal diameter 1, hooks as springs, interlock free or stuck, whichever is worse",
        )
        left, right = 0.95, 7.0
        panels = [style.axes(figure, x, y, 4.75, 3.7) for y in (5.55, 0.75) for x in (left, right)]
        size = lambda o: o.coordinates  # noqa: E731
        cost = lambda o: o.cost / unit  # noqa: E731
        _scatter(panels[0], found, size, Outcome.worst)
        panels[0].set(title="Worst of the first ten frequencies", xlabel="modal coordinates")
        _scatter(panels[1], found, cost, Outcome.worst)
        panels[1].set(
            title="The same against cost", xlabel="CPU time, factorisations of the vane's stiffness"
        )
        _scatter(panels[2], found, size, Outcome.second)
        panels[2].set(title="Second frequency", xlabel="modal coordinates")
        for panel in panels[:3]:
            panel.set(xscale="log", yscale="log", ylabel="relative error")
            panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
            panel.xaxis.set_minor_formatter(lambda value, _: "")
        for panel in (panels[0], panels[2]):
            panel.set_xticks([10, 20, 50, 100, 200, 500])
        panels[1].set_xticks([1, 2, 5, 10, 20, 50, 100])
        for panel in panels[:3]:  # room for the last label
            low, high = panel.dataLim.intervalx
            panel.set_xlim(low / 1.15, high * 1.35)
        figure.legend(
            *panels[0].get_legend_handles_labels(),
            loc="upper left",
            bbox_to_anchor=(left / style.WIDTH, 1 - 0.85 / 11.2),
            ncols=3,
            borderaxespad=0,
        )
        _estimates(panels[3], frequencies, response)
        style.write(figure, path)


def _scatter(axes: Axes, found: Found, across: Any, up: Any) -> None:
    """One point a setting; those of a kind are joined."""
    for interface, colour in COLOURS.items():
        row = [o for s, o in found if s.name.startswith(f"direct, {interface}")]
        axes.plot(
            [across(o) for o in row],
            [up(o) for o in row],
            "^-",
            color=colour,
            label=f"direct, {interface}: as many fixed as face modes",
        )
    row = [o for s, o in found if s.name.startswith("paper")]
    axes.plot(
        [across(o) for o in row],
        [up(o) for o in row],
        "D",
        color=style.GREY,
        label="paper: the same as direct, published",
    )
    by_modes = [o for s, o in found if s.name.startswith("cyclic") and s.modal]
    by_accuracy = [(s, o) for s, o in found if s.name.startswith("cyclic") and not s.modal]
    axes.plot(
        [across(o) for o in by_modes],
        [up(o) for o in by_modes],
        "s-",
        color=style.SKY,
        label="cyclic, number of modes",
    )
    axes.plot(
        [across(o) for _, o in by_accuracy],
        [up(o) for _, o in by_accuracy],
        "o-",
        color=style.BLUE,
        label="cyclic, accuracy",
    )
    for s, o in by_accuracy:
        axes.annotate(
            f"{s.casing['accuracy']:.0e}".replace("e-0", "e-"),
            (across(o), up(o)),
            xytext=(7, 3),
            textcoords="offset points",
            fontsize=9.5,
            color=style.BLUE,
        )


def _estimates(
    axes: Axes, frequencies: tuple[Floats, Floats], response: tuple[Floats, Floats]
) -> None:
    """Estimated errors against true ones."""
    ends = np.array([1e-8, 1.0])
    axes.fill_between(ends, 0.5 * ends, 10 * ends, color=style.LIGHT, alpha=0.5, linewidth=0)
    axes.plot(ends, ends, color=style.GREY, linewidth=1)
    axes.plot(*response, ".", color=style.SKY, markersize=3, label="response", rasterized=True)
    axes.plot(*frequencies, ".", color=style.BLUE, markersize=6, label="frequencies")
    axes.annotate(
        "from one half of the truth to ten times",
        (2.5e-8, 1.6e-7),
        rotation=39,
        fontsize=9.5,
        color=style.GREY,
        ha="left",
        va="bottom",
        rotation_mode="anchor",
    )
    axes.set(
        xscale="log",
        yscale="log",
        xlim=ends,
        ylim=ends,
        title='Estimated errors, route "cyclic"',
        xlabel="true relative error",
        ylabel="estimate",
    )
    axes.legend(loc="lower right", markerscale=1.5)


def responses(bench: Bench, found: Found, path: Path) -> None:
    """The unreduced response, the errors of a few reduced ones, and their estimates."""
    case = "stuck"
    hertz = bench.frequencies
    amplitude = abs(bench.truth[case]).max(axis=(1, 2))
    chosen = [
        ("cyclic, accuracy 1e-02", style.ORANGE),
        ("cyclic, accuracy 1e-04 (default)", style.BLUE),
        ("cyclic, accuracy 1e-06", style.PURPLE),
    ]
    published = next((s.name for s, _ in found if s.name.startswith("direct, pub") and _tens(s)))
    outcomes = {s.name: o for s, o in found}
    hertz, gaps = _with_gaps(hertz)
    with style.applied():
        figure = style.figure(
            8.9,
            "Response of the first harmonic and its error",
            "nodal diameter 1, interlock stuck, no damping; "
            "gaps: within 1 % of a natural frequency, the interlock free or stuck",
        )
        above = style.axes(figure, 1.0, 5.5, 10.6, 2.1)
        below = style.axes(figure, 1.0, 0.75, 10.6, 4.3)
        above.semilogy(hertz, gaps(amplitude), color=style.BLACK)
        above.set(ylabel="displacement, m/N", title="Largest output, unreduced")
        below.semilogy(
            hertz, gaps(outcomes[published].response[case]), color=style.VERMILION, label=published
        )
        for name, colour in chosen:
            o = outcomes[name]
            below.semilogy(hertz, gaps(o.response[case]), color=colour, label=name)
            estimated = np.maximum(o.estimated[case], FLOOR / 100)
            below.semilogy(bench.frequencies[::EVERY], estimated, "o", color=colour, markersize=4)
        below.plot([], [], "o", color=style.GREY, markersize=4, label="its estimate")
        below.set(
            ylabel="relative error of the response",
            xlabel="frequency, Hz",
            title="Errors",
            ylim=(FLOOR, None),
        )
        low, high = below.get_ylim()
        below.set_ylim(low, high * 30)
        below.legend(loc="upper left", ncols=3, fontsize=10)
        for axes in (above, below):
            axes.set_xlim(hertz[0], hertz[-1])
        style.write(figure, path)


def _tens(setting: Setting) -> bool:
    return setting.modal == setting.face and (setting.modal or 0) >= 10


def _with_gaps(hertz: Floats) -> tuple[Floats, Any]:
    """Frequencies with a break where some are left out, and how values get the same breaks."""
    step = np.diff(hertz).min()
    breaks = np.flatnonzero(np.diff(hertz) > 1.5 * step) + 1
    return np.insert(hertz, breaks, np.nan), lambda values: np.insert(values, breaks, np.nan)
