"""Maps, loops and preload of contacts, against closed forms; Campbell diagrams."""

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb

from vanelock import render
from vanelock.render import contact_map_picture, loop_picture, preload_picture, style
from vanelock.render.plots import contacts
from vanelock.render.shapes import contact_map


@pytest.fixture
def vane_contacts(coarse):
    """The coarse vane, and its contacts as a system orders them: hooks, then the interlock."""
    vane = coarse[0]
    sets = ("hook_front", "hook_rear", "interlock_right")
    nodes = np.concatenate([vane.node_sets[name] for name in sets])
    frames = np.concatenate([vane.frames[name] for name in sets])
    count = len(nodes) - len(vane.node_sets["interlock_right"])
    joints = ["hook"] * count + ["interlock"] * (len(nodes) - count)
    return vane, vane.points[nodes], frames, joints


def test_bands_are_unrolled_in_their_order(vane_contacts):
    vane, x, frames, joints = vane_contacts
    hook = np.array(joints) == "hook"
    places = contact_map._band_places(x[hook], frames[hook])
    # Roof and lip of the front hook, then of the rear one, 15 nodes each.
    np.testing.assert_array_equal(places[:, 1], np.repeat([0, 1, 2, 3], 15))
    reach = np.radians(0.9 * 180 / vane.sectors)
    for band, radius in enumerate((592, 584, 592, 584)):
        arc = places[15 * band : 15 * band + 15, 0]
        np.testing.assert_allclose(arc[[0, 7, 14]], [-reach * radius, 0, reach * radius], atol=1e-6)


def test_markers_show_state_and_energy(vane_contacts, figures):
    vane, x, frames, joints = vane_contacts
    count = len(joints)
    states = np.zeros((2, count), int)
    states[1, -10:] = [1, 1, 2, 3, 3, 3, 3, 3, 3, 3]
    energy = np.zeros((2, count))
    energy[1, -10:] = 1e-6 * np.array([50, 25, 0, 1, 2, 3, 4, 5, 6, 7])
    contact_map_picture(
        "map.png", vane, x, frames, joints, [250.0, 252.5], states, energy, "Contacts",
        "μ = 0.3", ("below", "at the peak"),
    )  # fmt: skip
    (figure,) = figures
    texts = [text.get_text() for text in figure.texts]
    assert "μ = 0.3. Largest marker: 50 µJ a cycle" in texts
    assert "at the peak, 252.50 Hz" in texts
    axes = [one for one in figure.axes if one.collections]
    assert len(axes) == 4
    face = [one for one in axes[2].collections if isinstance(one, PathCollection)]
    sizes = [np.asarray(one.get_sizes()).tolist() for one in face]
    assert [len(one) for one in sizes] == [2, 1, 7]
    low, high = contact_map._SMALL, contact_map._LARGE
    assert sizes[0] == pytest.approx([high, (low + high) / 2])
    assert sizes[1] == [low]
    colour = np.asarray(face[0].get_facecolor())[0, :3]
    assert colour == pytest.approx(to_rgb(style.VERMILION))
    labels = [text.get_text() for text in axes[2].texts]
    assert labels == [str(number) for number in range(1, 11)]


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
    force = np.column_stack([np.full_like(u, normal), t, zero])
    return np.column_stack([zero, u, zero]), force, force[:, 0]


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
    displacement, force, load = contact(u, t)
    turned = displacement[:, [0, 2, 1]], force[:, [0, 2, 1]], load
    loop_picture("x.png", *turned, MU, "Contact")
    assert figures[0].axes[0].get_xlabel() == "relative displacement, tangent 2 (µm)"


def test_isotropic_friction_slips_where_the_force_in_the_plane_is_at_its_bound(figures):
    angle = 2 * np.pi * np.arange(400) / 400
    share = np.where(angle < np.pi, 1.0, 0.5)  # at the bound for half the period
    t1, t2 = share * LIMIT * np.cos(angle), share * LIMIT * np.sin(angle)
    displacement = AMPLITUDE * np.column_stack([0 * angle, 2 * np.sin(angle), np.cos(angle)])
    load = np.full(400, LOAD)
    force = np.column_stack([load, t1, t2])
    loop_picture("x.png", displacement, force, load, MU, "Contact", isotropic=True)
    assert "sticks 50 %, slips 50 % of the period" in figures[0].texts[1].get_text()
    upper = figures[0].axes[2].lines[0].get_ydata()[:-1]
    np.testing.assert_allclose(upper, np.sqrt(LIMIT**2 - t2**2), atol=1e-12)
    # Bounded by twice the present load, the same force slips nowhere.
    loop_picture("x.png", displacement, force, 2 * load, MU, "Contact")
    assert "sticks 100 % of the period" in figures[1].texts[1].get_text()


FORCE = np.array([[100.0, 15.0, -3.0], [50.0, 0.0, -15.0], [0.0, 0.0, 0.0]])


OPENED = ["interlock", "interlock"]


def preload(path, force, mu, joints):
    used = contacts.utilisation(force, np.full(len(force), mu), False)
    return preload_picture(path, force[:, 0], used, joints, "at rest")


def test_preload_by_joint_of_open_contacts_and_of_those_without_friction(figures):
    """Open ones show no force whatever round-off says, those without friction have all slid."""
    preload("x.png", FORCE, 0.3, ["hook", "hook", "interlock"])
    titles = [axes.get_title(loc="left") for axes in figures[0].axes]
    assert titles == ["hook: 2 contacts\n50.0 to 100 N", "", "interlock: 1 contact\n0 N", ""]
    bars = [bar.get_height() for bar in figures[0].axes[0].patches]
    assert bars == [100.0, 50.0]
    ratios = [bar.get_height() for bar in figures[0].axes[1].patches]
    assert ratios == [0.5, 1.0]
    figures.clear()
    preload("x.png", np.array([[2.0, 0.1, 0.0], [0, 0, 0], [0, 0, 0]]), 0.3, ["hook", *OPENED])
    normal = [[bar.get_height() for bar in axes.patches] for axes in figures[0].axes]
    assert normal[0] == [2.0]
    assert normal[2] == [0.0, 0.0]
    hatched = [bar.get_height() for bar in figures[0].axes[3].patches if bar.get_hatch()]
    assert hatched == [1.0, 1.0]
    assert figures[0].axes[2].get_title(loc="left") == "interlock: 2 contacts\n0 N"
    force = np.array([[2.0, 0.0, 0.0], [1e-3, 1e-17, 0.0], [3.0, 1e-16, 1e-17]])
    assert list(contacts.utilisation(force, np.zeros(3), False)) == [1, 1, 1]
    assert list(contacts.utilisation(force, np.full(3, 1e-300), False)) == pytest.approx([0, 1, 1])


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


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_areas_are_as_amplitudes(figures):
    render.campbell_picture("c.png", SPEEDS, families(), [1, 2], crossings(), circles())
    axes, texts = figures[0].axes[0], legend(figures[0])
    full, linear = axes.collections
    assert full.get_sizes()[0] == pytest.approx(4 * linear.get_sizes()[0])
    assert len(linear.get_sizes()) == 1  # the last one could not be seen
    assert "nonlinear response:\nup to 4.00 µm (area)" in texts
    assert "linear response:\nup to 1.00 µm (area)" in texts


def test_lines_orders_and_the_crossing_of_interest(figures):
    render.campbell_picture("c.png", SPEEDS, families(), [1, 3], crossings())
    axes, texts = figures[0].axes[0], legend(figures[0])
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
