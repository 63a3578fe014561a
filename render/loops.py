"""Hysteresis of one contact: friction over sliding, and both forces over a period."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from vanelock.errors import InputError
from vanelock.render import style

Real = NDArray[np.float64]

STICKS, SLIPS, OPEN = 0, 1, 2
_NAMES: Final = ("sticks", "slips", "open")
_COLOURS: Final = (style.BLUE, style.VERMILION, style.GREY)


def loop_picture(
    path: style.PathLike,
    displacement: ArrayLike,
    force: ArrayLike,
    mu: float,
    title: str,
    subtitle: str = "",
    direction: int | None = None,
    bounding: ArrayLike | None = None,
    isotropic: bool = False,
) -> Path:
    """Draw a contact's hysteresis loop with its normal and friction force, and return the path.

    Left: friction force over relative displacement. Right: normal force, and friction force with
    its bounds ±μn, over the period; where friction is isotropic, what the other direction leaves of
    them. Colours tell where the contact sticks, slips or is open. The
    energy that friction takes in a cycle and the shares of the period stand under the title.

    Parameters
    ----------
    path : path
        PNG file to write.
    displacement : (s, 3) float
        v, u1, u2 at s equal steps of one period, without the repeated end, m.
    force : (s, 3) float
        n, t1, t2 at the same instants, N.
    mu : float
        Friction coefficient.
    title, subtitle : str
        Heading, such as "Interlock contact 3 at 252.3 Hz", and a line before the numbers.
    direction : {1, 2}, optional
        The friction direction shown; by default the one that takes more energy.
    bounding : (s,) float, optional
        The normal force that bounds friction; by default n.
    isotropic : bool
        Whether |t| <= μ n in the plane of both directions, or in each by itself.

    Raises
    ------
    InputError
        If the arrays do not fit together or the file cannot be written.
    """
    u, f = np.asarray(displacement, float), np.asarray(force, float)
    if u.ndim != 2 or u.shape[1:] != (3,) or u.shape != f.shape or len(u) < 4:
        raise InputError(
            f"loop: displacement of shape {u.shape} and force of shape {f.shape}: both must be "
            "(s, 3), s at least 4"
        )
    energy = [dissipated(u[:, k], f[:, k]) for k in (1, 2)]
    k = direction if direction in (1, 2) else 1 + int(energy[1] > energy[0])
    load = f[:, 0] if bounding is None else np.asarray(bounding, float)
    if isotropic:
        state = states(load, np.hypot(f[:, 1], f[:, 2]), mu)
        bound = np.sqrt(np.maximum((mu * load) ** 2 - f[:, 3 - k] ** 2, 0.0))
    else:
        state, bound = states(load, f[:, k], mu), mu * load
    shares = [f"{_NAMES[s]} {100 * np.mean(state == s):.0f} %" for s in np.unique(state)]
    taken = (
        f"Friction takes {_energy(energy[k - 1])} a cycle in t{k}, {_energy(sum(energy))} in all"
    )
    text = "; ".join([taken, f"{', '.join(shares)} of the period"])
    with style.applied():
        figure = style.figure(6.75, title, f"{subtitle}. {text}" if subtitle else text)
        loop = style.axes(figure, 1.0, 0.85, 4.7, 4.7)
        _loop(loop, u[:, k], bound, f[:, k], state, k)
        normal = style.axes(figure, 6.9, 3.55, 4.75, 2.0)
        friction = style.axes(figure, 6.9, 0.85, 4.75, 2.0)
        _history(normal, f[:, 0], state, "Normal load", "normal force n (N)")
        normal.set_ylim(bottom=min(0.0, float(f[:, 0].min())))
        _bounds(friction, bound)
        _history(friction, f[:, k], state, "Friction force and its bounds", f"force t{k} (N)")
        friction.set_xlabel("time / period (–)")
        shown = [Line2D([], [], color=_COLOURS[s], lw=3, label=_NAMES[s]) for s in np.unique(state)]
        shown.append(
            Line2D(
                [],
                [],
                color=style.BLACK,
                lw=1,
                ls=(0, (4, 3)),
                label="bounds" if isotropic else "bounds ±μn",
            )
        )
        loop.legend(
            handles=shown,
            ncols=len(shown),
            loc="lower left",
            bbox_to_anchor=(0, 1.0),
            borderpad=0,
            columnspacing=1.2,
            handlelength=1.4,
        )
        return style.write(figure, path)


def dissipated(displacement: Real, friction: Real) -> float:
    """Energy ∮ t du that friction takes in a cycle of equal steps, J (trapezoidal, closed)."""
    step = np.roll(displacement, -1) - displacement
    return float(np.sum((friction + np.roll(friction, -1)) / 2 * step))


def states(normal: Real, friction: Real, mu: float) -> NDArray[np.int64]:
    """STICKS, SLIPS or OPEN at each instant: |t| at its bound μn, or no normal force."""
    bound = mu * normal
    slack = 1e-6 * max(float(np.abs(bound).max()), np.finfo(float).tiny)
    state = np.where(np.abs(friction) >= bound - slack, SLIPS, STICKS)
    state[normal <= 1e-9 * max(float(normal.max()), np.finfo(float).tiny)] = OPEN
    return state


def _energy(joules: float) -> str:
    for factor, unit in ((1.0, "J"), (1e3, "mJ"), (1e6, "µJ")):
        if abs(joules) * factor >= 1:
            return f"{style.number(joules * factor)} {unit}"
    return f"{style.number(1e9 * joules)} nJ"


def _coloured(axes: Axes, x: Real, y: Real, state: NDArray[np.int64], width: float) -> None:
    """Broken line whose pieces have the colour of the state at their ends (the later one's)."""
    points = np.column_stack([x, y])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    shown = [_COLOURS[s] for s in state[1:]]
    axes.add_collection(
        LineCollection(list(pieces), colors=shown, linewidths=width, capstyle="round", zorder=3)
    )
    axes.autoscale_view()


def _closed(values: Any) -> Any:
    return np.append(values, values[:1])


def _loop(
    axes: Axes, u: Real, bound: Real, t: Real, state: NDArray[np.int64], direction: int
) -> None:
    micrometres = 1e6 * _closed(u)
    for sign in (1, -1):
        axes.plot(
            micrometres, sign * _closed(bound), color=style.BLACK, lw=1, ls=(0, (4, 3)), alpha=0.7
        )
    _coloured(axes, micrometres, _closed(t), _closed(state), 2.8)
    axes.set(
        xlabel=f"relative displacement u{direction} (µm)", ylabel=f"friction force t{direction} (N)"
    )
    axes.margins(0.06)


def _history(axes: Axes, force: Real, state: NDArray[np.int64], title: str, label: str) -> None:
    time = np.linspace(0, 1, len(force) + 1)
    _coloured(axes, time, _closed(force), _closed(state), 2.4)
    axes.set(xlim=(0, 1), ylabel=label, title=title)


def _bounds(axes: Axes, bound: Real) -> None:
    time = np.linspace(0, 1, len(bound) + 1)
    for sign in (1, -1):
        axes.plot(time, sign * _closed(bound), color=style.BLACK, lw=1, ls=(0, (4, 3)), alpha=0.7)
