"""Where the map puts a contact, how large it is drawn, and what it refuses."""

from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread

from vanelock.common.errors import InputError
from vanelock.render import contact_map_picture, style
from vanelock.render.scenes import scene
from vanelock.render.scenes.window import aimed, snapshot
from vanelock.render.shapes import contact_map


@pytest.fixture
def contacts(coarse):
    """The coarse vane, and its contacts as a system orders them: hooks, then the interlock."""
    vane = coarse[0]
    sets = ("hook_front", "hook_rear", "interlock_right")
    nodes = np.concatenate([vane.node_sets[name] for name in sets])
    frames = np.concatenate([vane.frames[name] for name in sets])
    count = len(nodes) - len(vane.node_sets["interlock_right"])
    joints = ["hook"] * count + ["interlock"] * (len(nodes) - count)
    return vane, vane.points[nodes], frames, joints


def test_places_in_a_picture_are_where_the_camera_sees_them():
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    spot = np.array([[0.4, -0.3, 0.6]])
    camera = scene.Camera((0.3, 0.2, -1), (0, 1, 0.1), square, margin=1.2)
    body = scene.SceneBody(square, np.array([[0, 1, 2], [0, 2, 3]]), "white")
    shown = scene.DrawnScene(camera, [body], marks=[scene.Marks(spot, style.VERMILION, 12)])
    picture = snapshot(shown, (400, 300)).astype(int)
    rows, columns = np.nonzero((picture[:, :, 0] > 120) & (picture[:, :, 2] < 60))
    (place,) = aimed(camera, square, (400, 300)).pixels(spot, (400, 300))
    np.testing.assert_allclose([columns.mean() + 0.5, rows.mean() + 0.5], place, atol=0.8)


def test_bands_are_unrolled_in_their_order(contacts):
    vane, x, frames, joints = contacts
    hook = np.array(joints) == "hook"
    places = contact_map._band_places(x[hook], frames[hook])
    # Roof and lip of the front hook, then of the rear one, 15 nodes each.
    np.testing.assert_array_equal(places[:, 1], np.repeat([0, 1, 2, 3], 15))
    reach = np.radians(0.9 * 180 / vane.sectors)
    for band, radius in enumerate((592, 584, 592, 584)):
        arc = places[15 * band : 15 * band + 15, 0]
        np.testing.assert_allclose(arc[[0, 7, 14]], [-reach * radius, 0, reach * radius], atol=1e-6)


def test_markers_show_state_and_energy(contacts, tmp_path, monkeypatch):
    figures: list[Figure] = []
    write = style.write

    def noted(figure, path):
        figures.append(figure)
        return write(figure, path)

    monkeypatch.setattr(style, "write", noted)
    vane, x, frames, joints = contacts
    count = len(joints)
    states = np.zeros((2, count), int)
    states[1, -10:] = [1, 1, 2, 3, 3, 3, 3, 3, 3, 3]
    energy = np.zeros((2, count))
    energy[1, -10:] = 1e-6 * np.array([50, 25, 0, 1, 2, 3, 4, 5, 6, 7])
    path = contact_map_picture(
        tmp_path / "map.png", vane, x, frames, joints, [250.0, 252.5], states, energy, "Contacts",
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
    assert imread(path).shape[1] == 1800


def test_without_an_interlock_nothing_is_rendered(contacts, tmp_path, monkeypatch):
    monkeypatch.setattr(contact_map, "snapshot", None)
    vane, x, frames, joints = contacts
    own = slice(len(joints) - 10)
    state = np.ones((1, len(joints) - 10), int)
    args = (vane, x[own], frames[own], joints[own], [250.0], state, 0.0 * state)
    assert contact_map_picture(tmp_path / "map.png", *args).is_file()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frequencies": np.arange(6.0)}, "given 6 frequencies: 1 to 5 fit into a figure"),
        ({"states": np.zeros((1, 3), int)}, r"states of shape \(1, 3\): \(1, 70\) is needed"),
        ({"states": np.full((1, 70), 4)}, "states: allowed are 0 to 3"),
        ({"positions": np.zeros((3, 3))}, r"positions of shape \(3, 3\)"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(contacts, tmp_path, change, message):
    vane, x, frames, joints = contacts
    given: dict[str, Any] = {
        "positions": x,
        "frames": frames,
        "joints": joints,
        "frequencies": [250.0],
        "states": np.zeros((1, 70), int),
        "dissipation": np.zeros((1, 70)),
    }
    with pytest.raises(InputError, match=f"contacts: .*{message}|contacts: {message}"):
        contact_map_picture(tmp_path / "map.png", vane, **(given | change))
    assert not list(tmp_path.iterdir())
