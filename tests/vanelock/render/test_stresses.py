"""Stress pictures: colours by value, marks, and refusals."""

import numpy as np
import pytest
from matplotlib.image import imread

from vanelock.common.errors import InputError
from vanelock.render import stress_picture, style


def dark(path, left):
    """Share of a panel's pixels near the map's upper end."""
    pixels = imread(path)[:, left : left + 700, :3]
    return float(np.mean(np.linalg.norm(pixels - style.AMPLITUDE_MAP(1.0)[:3], axis=2) < 0.2))


def test_colours_follow_the_stress_and_single_nodes_do_not_set_the_scale(sector, tmp_path):
    part = sector("vane", 0.4, 0.55, 0.08, 12, (3, 4, 2))
    high = np.where(part.points[:, 0] > np.median(part.points[:, 0]), 80e6, 0.0)
    outlier = high.copy()
    outlier[part.node_sets["output"]] = 1e12
    low = np.full(len(high), 1.0)
    low[0] = 1e3
    path = stress_picture(tmp_path / "a.png", part, outlier, 1e6 * low, "Stress", "case")
    assert imread(path).shape[:2] == (1035, 1800)
    assert 0.05 < dark(path, 40) < 0.5
    same = stress_picture(tmp_path / "b.png", part, high, 1e6 * low, "Stress", "case")
    assert np.mean(np.abs(imread(path) - imread(same)) > 0.05) < 5e-3


def test_colour_bars_are_in_mpa_and_stresses_that_do_not_fit_are_refused(sector, tmp_path, bars):
    part = sector("vane", 0.4, 0.55, 0.08, 12, (3, 4, 2))
    total, vibration = np.full(len(part.points), 40e6), np.full(len(part.points), 7e6)
    stress_picture(tmp_path / "a.png", part, total, vibration, "Stress")
    assert bars == [
        (0, pytest.approx(40), "von Mises stress (MPa)"),
        (0, pytest.approx(7), "von Mises stress (MPa)"),
    ]
    part = sector()
    good = np.ones(len(part.points))
    for bad in (good[1:], good * np.nan):
        with pytest.raises(InputError, match="casing: stresses of shape"):
            stress_picture(tmp_path / "a.png", part, good, bad, "Stress")
