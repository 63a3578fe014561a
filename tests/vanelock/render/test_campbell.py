"""Campbell diagrams: what is drawn where, read off the figure before it is written."""

import numpy as np
import pytest

from vanelock import render
from vanelock.common.errors import InputError
from vanelock.render import style
from vanelock.render.plots import campbell

SPEEDS = np.linspace(0.0, 12000.0, 5)


def crossings(n=3):
    speed = np.linspace(3000.0, 9000.0, n)
    return render.Crossings(
        np.ones(n, int), speed, speed / 60, np.arange(n) % 2 == 0, np.arange(n) == 1
    )


def families():
    free = np.column_stack([np.full(5, 100.0), 200 - SPEEDS / 1000])
    return [render.LineFamily(1, free, 1.1 * free), render.LineFamily(2, 1.5 * free, None)]


def circles(amplitude=(1e-6, 4e-6, 1e-9)):
    n = len(amplitude)
    return render.Circles(
        np.linspace(5000, 6000, n),
        np.linspace(5000, 6000, n) / 60,
        np.array(amplitude),
        np.arange(n) == 1,
    )


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """Function that draws a diagram and returns its axes, its legend's texts and the file."""

    def draw(*arguments, **options):
        kept = []
        write = style.write

        def keep(made, path):
            kept.append(made)
            return write(made, path)

        monkeypatch.setattr(style, "write", keep)
        path = render.campbell_picture(tmp_path / "c.png", *arguments, **options)
        (figure,) = kept
        texts = [text.get_text() for text in figure.legends[0].get_texts()]
        return figure.axes[0], texts, path

    return draw


def test_areas_are_as_amplitudes(drawn):
    axes, texts, path = drawn(SPEEDS, families(), [1, 2], crossings(), circles())
    full, linear = axes.collections
    assert full.get_sizes()[0] == pytest.approx(4 * linear.get_sizes()[0])
    assert len(linear.get_sizes()) == 1  # the last one could not be seen
    assert "nonlinear response:\nup to 4.00 µm (area)" in texts
    assert "linear response:\nup to 1.00 µm (area)" in texts
    assert path.stat().st_size > 10_000


def test_lines_orders_and_the_crossing_of_interest(drawn):
    axes, texts, _ = drawn(SPEEDS, families(), [1, 3], crossings())
    assert texts[:2] == ["nodal diameter 1", "nodal diameter 2"]
    assert texts[2:4] == ["interlock stuck", "interlock free"]
    assert axes.get_ylim() == pytest.approx((0, 1.12 * 1.5 * 200))
    said = [text.get_text() for text in axes.texts]
    assert said[:2] == ["EO 1", "EO 3"]
    assert said[2] == "6,000 rpm\n100.0 Hz"
    slopes = [
        line.get_ydata()[1] / line.get_xdata()[1]
        for line in axes.lines
        if len(line.get_xdata()) == 2
    ]
    assert slopes == pytest.approx([1 / 60, 3 / 60])


def test_measured_points_share_the_scale_or_have_their_own(drawn):
    dots = [
        render.Dots("rig", np.array([5000.0]), np.array([83.0]), np.array([2e-6])),
        render.Dots("strain", np.array([5000.0]), np.array([83.0]), np.array([3e-4]), True),
    ]
    axes, texts, _ = drawn(SPEEDS, families(), [1], crossings(), circles(), dots)
    largest = campbell._LARGEST
    sizes = [each.get_sizes()[0] for each in axes.collections[-2:]]
    assert sizes == pytest.approx([largest / 2, largest])
    assert texts[-3:-1] == ["rig", "strain"]


def test_nothing_to_draw(tmp_path):
    with pytest.raises(InputError, match="needs speeds, natural frequencies and engine orders"):
        render.campbell_picture(tmp_path / "c.png", SPEEDS, [], [1], crossings())
