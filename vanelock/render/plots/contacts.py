"""One contact's hysteresis over sliding and over a period; preload of all contacts."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from vanelock.common.arrays import Floats, Integers
from vanelock.common.tables import counted
from vanelock.render import style

STICKS, SLIPS, OPEN = 0, 1, 2
BROKEN: Final = (0, (4, 3))  # of the bounds' lines
_NAMES: Final = ("sticks", "slips", "open")
TANGENTS: Final = ("tangent 1", "tangent 2")
_COLOURS: Final = (style.BLUE, style.VERMILION, style.GREY)


def loop_picture(
    path: style.PathLike,
    displacement: Floats,
    force: Floats,
    load: Floats,
    mu: float,
    title: str,
    subtitle: str = "",
    isotropic: bool = False,
    tangents: tuple[str, str] = TANGENTS,
) -> Path:
    """Draw a contact's hysteresis loop with its normal and friction force, and return the path.

    Of the friction direction that takes more energy. Left: friction force over relative
    displacement. Right: normal force, and friction force with its bounds ±μn, over the period;
    where friction is isotropic, what the other direction leaves of them. Colours show where the
    contact sticks, slips or is open. The energy that friction takes in a cycle and the shares of
    the period stand under the title.

    Parameters
    ----------
    path : path
        PNG file to write.
    displacement : (s, 3) float
        v, u1, u2 at s equal steps of one period, without the repeated end, m.
    force : (s, 3) float
        n, t1, t2 at the same instants, N.
    load : (s,) float
        The normal force that bounds friction, N.
    mu : float
        Friction coefficient.
    title, subtitle : str
        Heading, such as "Contact 3 at 252.3 Hz", and a line before the numbers.
    isotropic : bool
        Whether |t| <= μ n in the plane of both directions, or in each by itself.
    tangents : (str, str)
        What the two directions are called.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    found = _period(displacement, force, load, mu, isotropic, tangents)
    text = "; ".join([found.taken, f"{found.shares} of the period"])
    with style.applied():
        figure = style.figure(6.75, title, f"{subtitle}. {text}" if subtitle else text)
        loop = style.axes(figure, 1.0, 0.85, 4.7, 4.7)
        _loop(loop, found)
        normal = style.axes(figure, 6.9, 3.55, 4.75, 2.0)
        friction = style.axes(figure, 6.9, 0.85, 4.75, 2.0)
        _histories(normal, friction, found)
        _legend(loop, found, isotropic)
        return style.write(figure, path)


@dataclass(frozen=True)
class _LoopPeriod:
    """What is shown of a contact's period in a direction, at equal steps, m and N.

    Its `state` is STICKS, SLIPS or OPEN; `taken` says the energy that friction takes.
    """

    direction: str
    sliding: Floats
    friction: Floats
    normal: Floats
    bound: Floats
    state: Integers
    taken: str

    @property
    def shares(self) -> str:
        """Shares of the period in each state, in words."""
        present = np.unique(self.state)
        return ", ".join(f"{_NAMES[s]} {100 * np.mean(self.state == s):.0f} %" for s in present)


def _period(
    u: Floats, f: Floats, load: Floats, mu: float, isotropic: bool, tangents: tuple[str, str]
) -> _LoopPeriod:
    """A contact's period in the direction that takes more energy, as of `loop_picture`."""
    energy = [_dissipated(u[:, k], f[:, k]) for k in (1, 2)]
    k = 1 + int(energy[1] > energy[0])
    if isotropic:
        state = _states(load, np.hypot(f[:, 1], f[:, 2]), mu)
        bound = np.sqrt(np.maximum((mu * load) ** 2 - f[:, 3 - k] ** 2, 0.0))
    else:
        state, bound = _states(load, f[:, k], mu), mu * load
    name = tangents[k - 1]
    own = f"{name} {_energy(energy[k - 1])}"
    taken = f"Friction dissipates {_energy(sum(energy))} per cycle ({own})"
    return _LoopPeriod(name, u[:, k], f[:, k], f[:, 0], bound, state, taken)


def _dissipated(displacement: Floats, friction: Floats) -> float:
    """Energy ∮ t du that friction takes in a cycle of equal steps, J (trapezoidal, closed)."""
    step = np.roll(displacement, -1) - displacement
    return float(np.sum((friction + np.roll(friction, -1)) / 2 * step))


def _states(normal: Floats, friction: Floats, mu: float) -> Integers:
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


def _coloured(axes: Axes, x: Floats, y: Floats, state: Integers, width: float) -> None:
    """Broken line whose pieces have the colour of the state at their ends (the later one's)."""
    points = np.column_stack([x, y])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    colours = [_COLOURS[s] for s in state[1:]]
    line = LineCollection(
        list(pieces), colors=colours, linewidths=width, capstyle="round", zorder=3
    )
    axes.add_collection(line)
    axes.autoscale_view()


def _closed(values: Any) -> Any:
    """Values of a period with the first one repeated at the end."""
    return np.append(values, values[:1])


def _loop(axes: Axes, period: _LoopPeriod) -> None:
    micrometres = 1e6 * _closed(period.sliding)
    for sign in (1, -1):
        bound = sign * _closed(period.bound)
        axes.plot(micrometres, bound, color=style.BLACK, lw=1, ls=BROKEN, alpha=0.7)
    _coloured(axes, micrometres, _closed(period.friction), _closed(period.state), 2.8)
    axes.set_xlabel(f"relative displacement, {period.direction} (µm)")
    axes.set_ylabel(f"friction force, {period.direction} (N)")
    axes.margins(0.06)


def _histories(normal: Axes, friction: Axes, loop: _LoopPeriod) -> None:
    """Draw the normal force, and below it friction with its bounds, over the period."""
    _history(normal, loop.normal, loop.state, "Normal load", "normal force n (N)")
    normal.set_ylim(bottom=min(0.0, float(loop.normal.min())))
    time = np.linspace(0, 1, len(loop.bound) + 1)
    for sign in (1, -1):
        bound = sign * _closed(loop.bound)
        friction.plot(time, bound, color=style.BLACK, lw=1, ls=BROKEN, alpha=0.7)
    title = f"Friction force, {loop.direction}, and its bounds"
    _history(friction, loop.friction, loop.state, title, "friction force (N)")
    friction.set_xlabel("time / period (–)")


def _history(axes: Axes, force: Floats, state: Integers, title: str, label: str) -> None:
    time = np.linspace(0, 1, len(force) + 1)
    _coloured(axes, time, _closed(force), _closed(state), 2.4)
    axes.set(xlim=(0, 1), ylabel=label, title=title)


def _legend(axes: Axes, period: _LoopPeriod, isotropic: bool) -> None:
    """Say above the axes what the colours and the broken lines are."""
    present = np.unique(period.state)
    shown = [Line2D([], [], color=_COLOURS[s], lw=3, label=_NAMES[s]) for s in present]
    bounds = "bounds" if isotropic else "bounds ±μn"
    shown.append(Line2D([], [], color=style.BLACK, lw=1, ls=BROKEN, label=bounds))
    axes.legend(
        handles=shown,
        ncols=len(shown),
        loc="lower left",
        bbox_to_anchor=(0, 1.0),
        borderpad=0,
        columnspacing=1.2,
        handlelength=1.4,
    )


def preload_picture(
    path: style.PathLike,
    normal: Floats,
    used: Floats,
    joints: Sequence[str],
    subtitle: str = "",
) -> Path:
    """Draw the static contact forces joint by joint, and return the path.

    Above: normal force n of each contact. Below: friction over its bound, |t| / (μ n), 1 where the
    contact slid at assembly, as it does without friction; an open contact is crossed out.

    Parameters
    ----------
    path : path
        PNG file to write.
    normal : (c,) float
        Normal force of each contact, N.
    used : (c,) float
        Its `utilisation`, NaN where it is open.
    joints : sequence of c str
        The joint that each contact belongs to.
    subtitle : str
        A line under the heading.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    names = list(dict.fromkeys(joints))
    counts = [sum(joint == name for joint in joints) for name in names]
    room = 10.6 - 0.75 * (len(names) - 1)
    # A joint of few contacts still needs room for its title.
    share = np.maximum(counts, 0.3 * max(counts))
    widths = room * share / share.sum()
    with style.applied():
        figure = style.figure(6.9, "Preload of the contacts", subtitle)
        left = 1.0
        for position, (name, width) in enumerate(zip(names, widths, strict=True)):
            chosen = np.array([joint == name for joint in joints])
            upper = style.axes(figure, left, 3.4, width, 2.15)
            lower = style.axes(figure, left, 1.05, width, 1.7)
            _bars(upper, normal[chosen], used[chosen])
            count = counted(int(chosen.sum()), "contact")
            upper.set_title(f"{name}: {count}\n{_range(normal[chosen])}")
            _ratios(lower, used[chosen])
            if position == 0:
                upper.set_ylabel("normal force n (N)")
                lower.set_ylabel("|t| / (μ n) (–)")
            left += width + 0.75
        figure.legend(
            handles=[
                Patch(color=style.BLUE, label="sticks"),
                Patch(color=style.VERMILION, label="slid at assembly"),
                Patch(facecolor="white", edgecolor=style.GREY, hatch="xxx", label="open"),
            ],
            loc="lower right",
            bbox_to_anchor=(11.65 / style.WIDTH, 0.1 / 6.9),
            ncols=3,
            borderpad=0,
        )
        return style.write(figure, path)


def utilisation(force: Floats, mu: Floats, isotropic: bool) -> Floats:
    """(c,) |t|, or the larger of |t1|, |t2|, over μn, at most 1; NaN where the contact is open.

    A bound of 0 is always reached: without friction what is left of t is round-off.
    """
    closed = force[:, 0] > 0
    bound = mu * force[:, 0]
    both = np.abs(force[:, 1:])
    largest = np.minimum(np.hypot(*both.T) if isotropic else both.max(axis=1), bound)
    ratio = np.divide(largest, bound, out=np.ones_like(bound), where=closed & (bound > 0))
    return np.where(closed, ratio, np.nan)


def _range(normal: Floats) -> str:
    low, high = float(normal.min()), float(normal.max())
    ends = style.number(low), style.number(high)
    return f"{ends[0]} N" if ends[0] == ends[1] else f"{ends[0]} to {ends[1]} N"


def _number(axes: Axes, count: int) -> Integers:
    axes.set(xlabel="contact", xlim=(0.3, count + 0.7))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=min(count, 10), min_n_ticks=1))
    axes.grid(False, axis="x")
    return np.arange(1, count + 1)


def _state_colours(used: Floats) -> list[str]:
    slid = np.nan_to_num(used) >= 1 - 1e-6
    return [style.VERMILION if one else style.BLUE for one in slid]


def _bars(axes: Axes, normal: Floats, used: Floats) -> None:
    axes.bar(_number(axes, len(normal)), normal, width=0.75, color=_state_colours(used))
    if not normal.any():
        axes.set_ylim(0, 1)
    axes.set_xlabel("")


def _ratios(axes: Axes, used: Floats) -> None:
    at = _number(axes, len(used))
    axes.bar(at, np.nan_to_num(used), width=0.75, color=_state_colours(used))
    opened = np.isnan(used)
    if opened.any():
        axes.bar(at[opened], 1.0, width=0.75, fc="white", ec=style.GREY, hatch="xxx", lw=0.8)
    axes.axhline(1, color=style.BLACK, lw=1, ls=(0, (4, 3)))
    axes.set_ylim(0, 1.12)
