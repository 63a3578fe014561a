"""Hysteresis loops against the closed form of one Jenkins element."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from vanelock.common.errors import InputError
from vanelock.render import loop_picture, preload_picture, style
from vanelock.render.plots.contacts import loops, preload

KT, MU, LOAD, AMPLITUDE = 1e6, 0.3, 10.0, 8e-6
LIMIT = MU * LOAD


def jenkins(steps=4000):
    """Steady loop of a Jenkins element under u = U cos θ and constant load, in closed form.

    From u = U it sticks until u = U - 2 t_lim/kt, then slips at -t_lim to u = -U, and back.
    """
    angle = 2 * np.pi * np.arange(steps) / steps
    u = AMPLITUDE * np.cos(angle)
    down = np.maximum(LIMIT - KT * (AMPLITUDE - u), -LIMIT)
    up = np.minimum(-LIMIT + KT * (AMPLITUDE + u), LIMIT)
    return u, np.where(angle <= np.pi, down, up)


def contact(u, t, normal=LOAD):
    zero = np.zeros_like(u)
    displacement = np.column_stack([zero, u, zero])
    return displacement, np.column_stack([np.full_like(u, normal), t, zero])


def test_an_open_contact_is_open_and_drawn(tmp_path):
    normal = np.array([5.0, 0.0, 0.0, 5.0])
    state = loops.states(normal, np.array([1.0, 0.0, 0.0, 1.5]), MU)
    assert list(state) == [loops.STICKS, loops.OPEN, loops.OPEN, loops.SLIPS]
    flat = np.zeros((64, 3))
    path = loop_picture(tmp_path / "open.png", flat, flat, MU, "Open contact")
    u, t = jenkins()
    other = loop_picture(tmp_path / "loop.png", *contact(u, t), MU, "Contact")
    assert other.stat().st_size > path.stat().st_size > 10_000


@pytest.fixture
def figures(monkeypatch):
    kept = []
    monkeypatch.setattr(style, "write", lambda figure, path: kept.append(figure))
    return kept


def test_the_figure_states_energy_and_shares_of_the_direction_that_takes_more(figures):
    u, t = jenkins()
    names = "radial", "along the slant"
    loop_picture("x.png", *contact(u, t), MU, "Interlock contact 3", "μ = 0.3", tangents=names)
    title, text = (item.get_text() for item in figures[0].texts)
    assert title == "Interlock contact 3"
    # 4 · 3 N · (8 - 3) µm = 60 µJ; it sticks while θ goes through arccos(1/4) twice.
    assert text == (
        "μ = 0.3. Friction dissipates 60.0 µJ per cycle (radial 60.0 µJ); "
        "sticks 42 %, slips 58 % of the period"
    )
    loop, normal, friction = figures[0].axes
    assert loop.get_xlabel() == "relative displacement, radial (µm)"
    assert loop.get_ylabel() == "friction force, radial (N)"
    assert normal.get_ylabel() == "normal force n (N)"
    assert friction.get_xlabel() == "time / period (–)"
    figures.clear()
    u, t = jenkins()
    displacement, force = contact(u, t)
    turned = displacement[:, [0, 2, 1]], force[:, [0, 2, 1]]
    loop_picture("x.png", *turned, MU, "Contact")
    loop_picture("x.png", *turned, MU, "Contact", direction=1)
    shown = [figure.axes[0].get_xlabel() for figure in figures]
    assert shown == [f"relative displacement, tangent {i} (µm)" for i in (2, 1)]


def test_isotropic_friction_slips_where_the_force_in_the_plane_is_at_its_bound(figures):
    angle = 2 * np.pi * np.arange(400) / 400
    share = np.where(angle < np.pi, 1.0, 0.5)  # at the bound for half the period
    t1, t2 = share * LIMIT * np.cos(angle), share * LIMIT * np.sin(angle)
    displacement = AMPLITUDE * np.column_stack([0 * angle, np.sin(angle), np.cos(angle)])
    force = np.column_stack([np.full(400, LOAD), t1, t2])
    loop_picture("x.png", displacement, force, MU, "Contact", direction=1, isotropic=True)
    assert "sticks 50 %, slips 50 % of the period" in figures[0].texts[1].get_text()
    upper = figures[0].axes[2].lines[0].get_ydata()[:-1]
    np.testing.assert_allclose(upper, np.sqrt(LIMIT**2 - t2**2), atol=1e-12)
    # Bounded by twice the present load, the same force slips nowhere.
    loop_picture("x.png", displacement, force, MU, "Contact", bounding=np.full(400, 2 * LOAD))
    assert "sticks 100 % of the period" in figures[1].texts[1].get_text()


def test_the_loop_closes_and_every_piece_has_its_state(figures):
    u, t = jenkins(400)
    loop_picture("x.png", *contact(u, t), MU, "Contact")
    (pieces,) = figures[0].axes[0].collections
    drawn = np.array(pieces.get_segments())
    np.testing.assert_allclose(drawn[0, 0], drawn[-1, 1])
    np.testing.assert_allclose(drawn[:, 0, 0], 1e6 * u)
    np.testing.assert_allclose(drawn[:, 0, 1], t)
    colours = {tuple(np.round(c, 6)) for c in pieces.get_colors()}
    assert len(colours) == 2


FORCE = np.array([[100.0, 15.0, -3.0], [50.0, 0.0, -15.0], [0.0, 0.0, 0.0]])


def test_preload_by_joint_of_open_contacts_and_of_those_without_friction(figures):
    """Open ones show no force whatever round-off says, those without friction have all slid."""
    preload_picture("x.png", FORCE, 0.3, ["hook", "hook", "interlock"], subtitle="at rest")
    titles = [axes.get_title(loc="left") for axes in figures[0].axes]
    assert titles == ["hook: 2 contacts\n50.0 to 100 N", "", "interlock: 1 contact\n0 N", ""]
    bars = [bar.get_height() for bar in figures[0].axes[0].patches]
    assert bars == [100.0, 50.0]
    ratios = [bar.get_height() for bar in figures[0].axes[1].patches]
    assert ratios == [0.5, 1.0]
    figures.clear()
    force = np.array([[2.0, 0.1, 0.0], [4e-16, 1e-16, 0.0], [-4e-16, 0.0, 1e-15]])
    joints = ["hook", "interlock", "interlock"]
    preload_picture("x.png", force, 0.3, joints, opened=[False, True, True])
    normal = [[bar.get_height() for bar in axes.patches] for axes in figures[0].axes]
    assert normal[0] == [2.0]
    assert normal[2] == [0.0, 0.0]
    hatched = [bar.get_height() for bar in figures[0].axes[3].patches if bar.get_hatch()]
    assert hatched == [1.0, 1.0]
    assert figures[0].axes[2].get_title(loc="left") == "interlock: 2 contacts\n0 N"
    figures.clear()
    force = np.array([[2.0, 0.0, 0.0], [1e-3, 1e-17, 0.0], [3.0, 1e-16, 1e-17]])
    assert list(preload.utilisation(force, np.zeros(3))) == [1, 1, 1]
    assert list(preload.utilisation(force, np.full(3, 1e-300))) == pytest.approx([0, 1, 1])
    preload_picture("x.png", force, 0.0, ["hook"] * 3)
    upper = figures[0].axes[0]
    assert {to_hex(bar.get_facecolor()) for bar in upper.patches} == {style.VERMILION}


def test_arrays_that_do_not_fit_are_refused(tmp_path):
    path, wrong = tmp_path / "x.png", np.zeros((3, 8))
    with pytest.raises(InputError, match=r"displacement of shape \(3, 8\)"):
        loop_picture(path, wrong, wrong, MU, "Contact")
    with pytest.raises(InputError, match=r"force of shape \(3, 3\): \(2, 3\) is needed"):
        preload_picture(path, FORCE, 0.3, ["hook", "hook"])
