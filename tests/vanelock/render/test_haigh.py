"""Haigh diagrams: Goodman's line where its ends are by hand."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from vanelock.common.errors import InputError
from vanelock.render import Named, haigh_picture
from vanelock.render.plots.haigh import _line, _marks


@pytest.mark.parametrize("n", [1.0, 2.5])
def test_line_ends_at_the_strengths_over_the_reserve(n):
    axes = Figure().add_subplot()
    axes.set_xlim(-50, 1000)
    _line(axes, 250e6, 900e6, n)
    (line,) = axes.lines
    x, y = (np.asarray(each) for each in line.get_data())
    assert (x[1], y[1]) == pytest.approx((0, 250 / n))
    assert (x[2], y[2]) == pytest.approx((900 / n, 0))
    assert y[0] == y[1]  # flat in compression


def test_marks_tell_features_and_gauges_apart():
    named = [Named(f"{i}", 0.0, 1.0, gauge=i > 4) for i in range(8)]
    assert len(set(_marks(named))) == 8


def test_picture_is_written_or_refused(tmp_path):
    stress = np.array([1e6, 5e6, 2e6])
    path = haigh_picture(
        tmp_path / "haigh.png", stress, 2 * stress, stress > 4e6, 250e6, 900e6, [], "Title"
    )
    assert imread(path).shape[1] == 1800
    with pytest.raises(InputError, match="one value of each for every place"):
        haigh_picture(
            tmp_path / "no.png", stress[:2], stress, stress > 0, 250e6, 900e6, [], "Title"
        )
    assert not (tmp_path / "no.png").exists()
