"""Pictures of the scenes' errors and costs."""

from pathlib import Path

import numpy as np

from benchmarks.accuracy.runs import Setting
from benchmarks.accuracy.tables import SHARE, Compared
from vanelock.render import style

FLOOR = 1e-8
"""Errors are drawn no lower."""
COLOURS = (style.BLUE, style.GREEN, style.VERMILION)


def errors(asked: dict[float, Compared], path: Path) -> None:
    """The error of every scene by the accuracy asked for."""
    with style.applied():
        figure = style.figure(
            5.6,
            "Achieved error of the peak, by the accuracy asked for",
            "each point a scene: the larger of the relative errors of amplitude and frequency; "
            "line: asked for, dotted: 30 times less",
        )
        panel = style.axes(figure, 0.95, 0.75, 10.6, 3.75)
        for place, (accuracy, found) in enumerate(asked.items()):
            order = np.sort(found.worst.clip(FLOOR))
            x = place + np.linspace(-0.38, 0.38, len(order))
            outside = order >= accuracy
            panel.plot(x[~outside], order[~outside], "o", ms=4, color=COLOURS[place])
            panel.plot(x[outside], order[outside], "x", ms=6, color=style.BLACK)
            panel.plot([place - 0.42, place + 0.42], [accuracy] * 2, "-", color=COLOURS[place])
            panel.plot([place - 0.42, place + 0.42], [accuracy / 30] * 2, ":", color=COLOURS[place])
        panel.set(yscale="log", ylabel="relative error of the peak", xlabel="accuracy asked for")
        panel.set_xticks(range(len(asked)), [f"{accuracy:g}" for accuracy in asked])
        figure.savefig(path)


def costs(
    asked: dict[float, Compared], fixed: dict[Setting, Compared], unit: float, path: Path
) -> None:
    """Mean cost against the error that 95 % of the scenes stay within, and against the worst."""
    with style.applied():
        figure = style.figure(
            5.6,
            "Error against cost",
            "mean CPU time of reduction and response, in units; "
            "numbers: fixed harmonics, or the accuracy",
        )
        panels = [style.axes(figure, x, 0.75, 4.6, 3.5) for x in (1.05, 7.1)]
        titles = ("95 % of the scenes stay within", "the worst scene")
        for panel, title, share in zip(panels, titles, (SHARE, 1.0), strict=True):
            for parts, marker, words in (
                (False, "s", "fixed, swept up"),
                (True, "D", "fixed, in parts, up and down"),
            ):
                some = {s: found for s, found in fixed.items() if bool(s.parts) == parts}
                x = [found.cost / unit for found in some.values()]
                y = [max(found.reaches(share), FLOOR) for found in some.values()]
                colour = style.BLACK if parts else style.VERMILION
                panel.plot(x, y, marker, ms=5, color=colour, label=words)
                for setting, a, b in zip(some, x, y, strict=True):
                    panel.annotate(
                        f"{setting.harmonics}",
                        (a, b),
                        xytext=(-5, -4),
                        textcoords="offset points",
                        ha="right",
                    )
            x = [found.cost / unit for found in asked.values()]
            y = [max(found.reaches(share), FLOOR) for found in asked.values()]
            panel.plot(x, y, "o-", ms=5, color=style.BLUE, label="by accuracy")
            for accuracy, a, b in zip(asked, x, y, strict=True):
                panel.annotate(f"{accuracy:g}", (a, b), xytext=(6, 2), textcoords="offset points")
            panel.set(xscale="log", yscale="log", title=title, xlim=(0.4, 12), ylim=(5e-5, 1))
            panel.set_xticks([0.5, 1, 2, 5, 10])
            panel.set(xlabel="CPU time, units", ylabel="relative error of the peak")
            panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
            panel.xaxis.set_minor_formatter(lambda value, _: "")
            panel.legend(loc="lower left")
        figure.savefig(path)
