"""Preload of the contacts: normal force of each pair, and how much of its friction is used up."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.tables import counted
from vanelock.render import style


def preload_picture(
    path: style.PathLike,
    force: ArrayLike,
    mu: ArrayLike,
    joints: Sequence[str],
    title: str = "Preload of the contacts",
    subtitle: str = "",
    opened: ArrayLike | None = None,
    isotropic: bool = False,
) -> Path:
    """Draw the static contact forces joint by joint, and return the path.

    Above: normal force n of each contact. Below: friction over its bound, |t| / (μ n), 1 where the
    contact slid at assembly, as it does without friction; an open contact is crossed out.

    Parameters
    ----------
    path : path
        PNG file to write.
    force : (c, 3) float
        n, t1, t2 of each contact, N.
    mu : (c,) float or float
        Friction coefficient.
    joints : sequence of c str
        The joint that each contact belongs to.
    title, subtitle : str
        Heading and the line under it.
    opened : (c,) bool, optional
        Which contacts are open, whatever round-off their forces show; by default those that do
        not press.
    isotropic : bool
        Whether |t| is that of the plane, or the larger one of both directions.

    Raises
    ------
    InputError
        If the arrays do not fit together or the file cannot be written.
    """
    f = np.asarray(force, float)
    if f.ndim != 2 or f.shape != (len(joints), 3) or not len(joints):
        raise InputError(f"preload: force of shape {f.shape}: ({len(joints)}, 3) is needed")
    apart = f[:, 0] <= 0 if opened is None else np.asarray(opened, bool)
    if apart.shape != (len(f),):
        raise InputError(f"preload: opened of shape {apart.shape}: ({len(f)},) is needed")
    f = np.where(apart[:, None], 0.0, f)
    used = utilisation(f, np.broadcast_to(np.asarray(mu, float), len(f)), isotropic)
    names = list(dict.fromkeys(joints))
    counts = [sum(joint == name for joint in joints) for name in names]
    room = 10.6 - 0.75 * (len(names) - 1)
    # A joint of few contacts still needs room for its title.
    share = np.maximum(counts, 0.3 * max(counts))
    widths = room * share / share.sum()
    with style.applied():
        figure = style.figure(6.9, title, subtitle)
        left = 1.0
        for position, (name, width) in enumerate(zip(names, widths, strict=True)):
            chosen = np.array([joint == name for joint in joints])
            upper = style.axes(figure, left, 3.4, width, 2.15)
            lower = style.axes(figure, left, 1.05, width, 1.7)
            _bars(upper, f[chosen, 0], used[chosen])
            upper.set_title(
                f"{name}: {counted(int(chosen.sum()), 'contact')}\n{_range(f[chosen, 0])}"
            )
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


def utilisation(force: Floats, mu: Floats, isotropic: bool = False) -> Floats:
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


def _number(axes: Axes, count: int) -> NDArray[np.int64]:
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
