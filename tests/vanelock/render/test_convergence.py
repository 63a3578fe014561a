"""Error against cost: what a panel shows."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from vanelock import render
from vanelock.common.errors import InputError
from vanelock.render import style
from vanelock.render.plots import convergence

NAN = float("nan")
VALUES = (
    render.MeasuredValue("1", 0.1, 1e-2, 1e-3, False),
    render.MeasuredValue("3", 0.4, 1e-3, 1e-9, True),
    render.MeasuredValue("adaptive", 0.2, 1e-4, 1e-5, False, joined=False),
    render.MeasuredValue("9", 1.2, NAN, NAN, False),
)


@pytest.fixture
def axes():
    found = style.axes(Figure((6, 4)), 1, 1, 4, 2)
    convergence._draw(found, render.Panel("response.harmonics", VALUES))
    return found


def test_values_are_named_joined_in_sequences_and_the_reference_is_a_line_at_its_cost(axes):
    joined = [line.get_xydata() for line in axes.lines if line.get_linestyle() == "-"]
    np.testing.assert_allclose(joined[0], [[0.1, 1e-2], [0.4, 1e-3]])
    # An error too small to be drawn lies at the foot.
    np.testing.assert_allclose(joined[1], [[0.1, 1e-3], [0.4, 1e-7]])
    assert [text.get_text() for text in axes.texts] == ["1", "3", "adaptive", "9"]
    assert [text.get_fontweight() for text in axes.texts] == ["normal", "bold", "normal", "normal"]
    large = [line for line in axes.lines if line.get_markersize() == 8]
    assert [line.get_xdata().tolist() for line in large] == [[0.4], [0.4]]
    (dotted,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    assert set(dotted.get_xdata()) == {1.2}


def test_a_picture_needs_a_panel(tmp_path):
    with pytest.raises(InputError, match="none given"):
        render.convergence_picture(tmp_path / "none.png", [], "x")
