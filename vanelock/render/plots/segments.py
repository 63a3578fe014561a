"""Segments of a ring that are not alike: their response curves, and how far each is amplified."""

from pathlib import Path

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from vanelock.common.errors import InputError
from vanelock.render import style


def segments_picture(
    path: style.PathLike,
    frequency: ArrayLike,
    amplitude: ArrayLike,
    alike: tuple[ArrayLike, ArrayLike],
    amplification: ArrayLike,
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw the curves of all segments, and bars of their largest amplitudes, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    frequency : (p,) float
        Hz.
    amplitude : (p, N) float
        Of every segment, m; NaN where unknown.
    alike : (q,) float, (q,) float
        Frequency and amplitude, Hz and m, were all segments alike.
    amplification : (N,) float
        Largest amplitude of each segment over that of alike ones.
    title, subtitle : str
        Heading and the line under it.

    Raises
    ------
    InputError
        If the arrays do not fit together or the file cannot be written.
    """
    hertz, moved, ratio = (np.asarray(a, float) for a in (frequency, amplitude, amplification))
    if moved.shape != (len(hertz), len(ratio)) or not len(ratio):
        raise InputError(
            f"segments: amplitude of shape {moved.shape}: ({len(hertz)}, {len(ratio)}) is needed"
        )
    worst = int(np.argmax(np.nan_to_num(ratio)))
    with style.applied():
        figure = style.figure(7.2, title, subtitle)
        upper = style.axes(figure, 1.0, 3.45, 10.4, 2.75)
        upper.plot(hertz, 1e6 * moved, color=style.SKY, linewidth=0.9)
        upper.plot([], [], color=style.SKY, linewidth=0.9, label="segments")
        own = f"segment {worst + 1}, the worst"
        upper.plot(hertz, 1e6 * moved[:, worst], color=style.VERMILION, linewidth=1.8, label=own)
        base = np.asarray(alike[0], float), 1e6 * np.asarray(alike[1], float)
        upper.plot(*base, color=style.BLACK, linewidth=1.4, linestyle="--", label="alike segments")
        upper.set(xlabel="excitation frequency (Hz)", ylabel="amplitude (µm)", ylim=(0, None))
        upper.set_xlim(hertz.min(), hertz.max())
        upper.legend(loc="best")
        lower = style.axes(figure, 1.0, 0.75, 10.4, 1.75)
        colours = [style.VERMILION if i == worst else style.BLUE for i in range(len(ratio))]
        lower.bar(np.arange(len(ratio)) + 1, ratio - 1, bottom=1.0, color=colours, width=0.7)
        lower.axhline(1.0, color=style.BLACK, linewidth=1.0)
        lower.xaxis.set_major_locator(MaxNLocator(16, integer=True))
        lower.set(xlabel="segment", ylabel="amplification (–)", xlim=(0.4, len(ratio) + 0.6))
        lower.grid(False, axis="x")
        return style.write(figure, path)
