"""Measured curves with the response before and after a fit, and the residuals between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes

from vanelock.common.arrays import Floats
from vanelock.render import style

_BEFORE, _AFTER = (style.GREY, (0, (5, 2.5))), (style.BLUE, "-")


@dataclass(frozen=True)
class FitPanel:
    """A measured curve and the computed response.

    Attributes
    ----------
    name : str
        Of the measurement.
    unit : str
        Unit in which amplitudes, given in m or 1, are drawn: "µm" or "µm/m".
    frequency, amplitude : (p,) float
        Measured, Hz.
    sigma : (p,) float or None
        Standard deviations.
    remainder : (p,) float
        Fitted minus measured; NaN where there is no fitted value.
    hertz, before, after : (q,) float
        The response with the study's values and with the fitted ones; NaN where there is none.
    """

    name: str
    unit: str
    frequency: Floats
    amplitude: Floats
    sigma: Floats | None
    remainder: Floats
    hertz: Floats
    before: Floats
    after: Floats


def fit_picture(
    path: style.PathLike, panels: Sequence[FitPanel], title: str, subtitle: str
) -> Path:
    """Draw measured curves over the response before and after a fit, and return the path.

    Below each curve stand the residuals, fitted minus measured, between two standard deviations
    where these are known.

    Parameters
    ----------
    path : path
        PNG file to write.
    panels : sequence of FitPanel
        One for each measured curve.
    title, subtitle : str
        Heading, and a line below it, such as the fitted values.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    across = 1 if len(panels) == 1 else 2
    down = -(-len(panels) // across)
    head = 1.0 if len(panels) == 1 else 1.3  # room for the title, and the panels' names
    height = head + 0.1 + 5.0 * down
    width = (10.6 - 0.9 * (across - 1)) / across
    with style.applied():
        figure = style.figure(height, title, subtitle)
        for i, panel in enumerate(panels):
            row, column = divmod(i, across)
            left = 0.95 + column * (width + 0.9)
            bottom = height - head - 5.0 * (row + 1) + 0.8
            upper = style.axes(figure, left, bottom + 1.45, width, 2.75)
            lower = style.axes(figure, left, bottom, width, 1.05)
            _curves(upper, panel, len(panels) > 1)
            _remainder(lower, panel)
            lower.set_xlim(upper.get_xlim())
            upper.tick_params(labelbottom=False)
        return style.write(figure, path)


def _curves(axes: Axes, panel: FitPanel, named: bool) -> None:
    axes.plot(panel.hertz, 1e6 * panel.before, color=_BEFORE[0], ls=_BEFORE[1], label="study")
    axes.plot(panel.hertz, 1e6 * panel.after, color=_AFTER[0], ls=_AFTER[1], lw=2.2, label="fitted")
    bars = None if panel.sigma is None else 2e6 * panel.sigma
    axes.errorbar(
        panel.frequency,
        1e6 * panel.amplitude,
        bars,
        ls="",
        marker="o",
        ms=4.5,
        mfc="white",
        color=style.BLACK,
        elinewidth=0.9,
        label="measured" if bars is None else "measured, ±2σ",
        zorder=4,
    )
    axes.set_ylabel(f"amplitude ({panel.unit})")
    axes.set_ylim(bottom=0)
    if named:
        axes.set_title(panel.name)
    axes.legend(loc="upper right", fontsize=10.5)


def _remainder(axes: Axes, panel: FitPanel) -> None:
    if panel.sigma is not None:
        band = 2e6 * panel.sigma
        axes.fill_between(panel.frequency, -band, band, color=style.LIGHT, lw=0, zorder=1)
    axes.axhline(0, color=style.GREY, lw=0.8)
    axes.plot(panel.frequency, 1e6 * panel.remainder, ".-", color=style.BLUE, lw=0.9)
    axes.set(xlabel="excitation frequency (Hz)", ylabel=f"residual ({panel.unit})")
