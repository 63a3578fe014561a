"""Fatigue margins against what is done by hand; places of nodes in words, sharp corners, areas."""

import numpy as np
import pytest

from vanelock import mesh, parse_study
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry.aerofoil import output_points
from vanelock.quantities.stress.fatigue import _half_chord, cycle
from vanelock.quantities.stress.locations import _reentrant_edges, locations_of
from vanelock.quantities.stress.margins import _Strength
from vanelock.stages.parts.outputs import _places_on

STEEL = _Strength(limit=200e6, tensile=800e6)


def tension(value):
    return np.array([value, 0, 0, 0, 0, 0], complex)


def shear(value):
    return np.array([0, 0, 0, 0, 0, value], complex)


def periodic(*coefficients):
    return np.stack(coefficients)[:, None]


TURNING = tension(100e6) - 1j * shear(100e6 / 3**0.5)
"""A cosine in tension and a sine / √3 in shear: von Mises 100 MPa at every instant."""
S = 120e6
"""A uniaxial stress whose axis turns: (1 + cos 2θ)/2, (1 - cos 2θ)/2, sin 2θ/2 times this. What
alternates is a shear S/2 of turning axes, √3/2 S by von Mises; the mean is S/2 twice."""
IN_PLANE = np.array([S / 2, S / 2, 0, 0, 0, 0], complex)
TURNS = np.array([S / 2, -S / 2, 0, 0, 0, -1j * S / 2])
ROOT = 3**0.5


@pytest.mark.parametrize(
    ("harmonics", "amplitude", "mean", "mises"),
    [
        ((tension(400e6), tension(50e6 * np.exp(0.7j))), 50e6, 400e6, 400e6),
        ((tension(-400e6), tension(50e6)), 50e6, -400e6, -400e6),
        ((shear(100e6), tension(50e6)), 50e6, 0, 100e6 * ROOT),
        ((tension(0), shear(50e6)), 50e6 * ROOT, 0, 0),
        ((tension(0), TURNING), 100e6, 0, 0),
        ((IN_PLANE, TURNS), ROOT / 2 * S, S, S / 2),
        ((tension(0), tension(100e6), tension(50e6)), 150e6, 0, 0),
    ],
)
def test_amplitude_and_mean_are_those_by_hand(harmonics, amplitude, mean, mises):
    found = cycle(periodic(*harmonics))
    given = found.amplitude[0], found.mean[0], found.mean_mises[0]
    assert given == pytest.approx((amplitude, mean, mises))


def test_goodman_margins_are_those_of_a_textbook():
    """50/200 + 400/800 = 0.75, beside 400 MPa half of the limit; compression is no help."""
    assert STEEL.reserve(50e6, 400e6) == pytest.approx(4 / 3)
    assert STEEL.growth(50e6, 400e6) == pytest.approx(2)
    assert STEEL.reserve(50e6, -400e6) == pytest.approx(4)
    assert STEEL.reserve(0.0, 0.0) == np.inf
    assert STEEL.growth(10e6, 900e6) == 0


def test_chords_of_what_turns_and_of_two_harmonics():
    """Their sum cos θ + cos 2θ / 2 goes from -3/4 to 3/2: 1.125 half of the range."""
    assert cycle(periodic(tension(0), TURNING)).chord[0] == pytest.approx(100e6)
    found = cycle(periodic(tension(0), tension(100e6), tension(50e6)))
    assert found.chord[0] == pytest.approx(112.5e6, rel=2e-3)


def test_chord_is_that_of_all_pairs_of_instants_and_within_the_distance_from_the_mean():
    random = np.random.default_rng(5)
    harmonics = random.normal(size=(4, 40, 6)) + 1j * random.normal(size=(4, 40, 6))
    found = cycle(harmonics)
    assert np.all(found.chord <= found.amplitude * (1 + 1e-9))
    assert np.all(found.chord > 0.5 * found.amplitude)
    random = np.random.default_rng(6)
    h = random.normal(size=(3, 1, 6)) + 1j * random.normal(size=(3, 1, 6))
    h[0] = 0
    t = 2 * np.pi * np.arange(400) / 400
    s = np.einsum("hc,ht->tc", h[:, 0], np.exp(1j * np.outer(np.arange(3), t))).real
    d = s[:, None] - s[None]
    x, y, z, yz, zx, xy = np.moveaxis(d, -1, 0)
    vm = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3 * (yz**2 + zx**2 + xy**2))
    assert 0.98 * vm.max() / 2 <= _half_chord(h)[0] <= vm.max() / 2 * (1 + 1e-4)


@pytest.fixture(scope="module")
def study():
    return parse_study('[vane]\nroot_fillet = 0\n[mesh]\nsize = "coarse"')


@pytest.fixture(scope="module")
def vane(study):
    return mesh.vane_segment(study.vane, size="coarse")


@pytest.fixture(scope="module")
def found(study, vane):
    return locations_of(study, vane)


def test_sharp_corners_are_where_the_drawing_has_them_and_fillets_leave_only_the_roots(vane):
    edges = _reentrant_edges(vane)
    radius = np.unique(np.hypot(*edges[..., :2].reshape(-1, 2).T).round(4))
    # Roots of the aerofoils, and the leg's corners at the shroud and the foot.
    assert radius.tolist() == [0.432, 0.567, 0.573, 0.584]
    dimensions = VaneDimensions(fillet=0.002, root_fillet=0.0)
    edges = _reentrant_edges(mesh.vane_segment(dimensions, size="coarse"))
    radius = np.hypot(*edges[..., :2].reshape(-1, 2).T)
    assert radius.max() < 0.568


def test_fillets_of_hooks_and_roots_leave_none(study):
    """The roots are judged: their nodes belong to an aerofoil, and none lies beside a corner."""
    dimensions = VaneDimensions(fillet=0.002, root_fillet=0.0025, lean=4.0, twist=6.0, aerofoils=2)
    part = mesh.vane_segment(dimensions, size="coarse")
    assert len(_reentrant_edges(part)) == 0
    found = locations_of(study.model_copy(update={"vane": dimensions}), part)
    assert not found.corner.any()
    radius = np.hypot(*part.points[:, :2].T)
    fillet = (radius > 0.4321) & (radius < 0.434) | (radius > 0.565) & (radius < 0.5669)
    assert fillet.sum() > 500
    assert all(name.startswith("aerofoil") for name in found.feature[fillet])
    words = {found.words(int(node)).split(",")[1] for node in np.flatnonzero(fillet)}
    assert words == {" root at the inner shroud", " root at the outer shroud"}


def test_output_nodes_are_named_as_they_were_placed(study, vane, found):
    # By construction at mid-chord of the suction side of the middle aerofoil, at quarters.
    nodes = vane.node_sets["output"]
    placed = output_points(study.vane, 16)
    for node, point, share in zip(nodes, placed, (25, 50, 75), strict=True):
        assert vane.points[node] == pytest.approx(point)
        place = found.words(int(node))
        assert place == f"aerofoil 2, {share} % of the span, suction side, 50 % of the chord"


def test_features_are_where_the_dimensions_put_them(vane, found):
    x, y, z = vane.points.T
    radius = np.hypot(x, y)
    assert set(found.feature[radius < 0.4319]) == {"inner shroud"}
    assert set(found.feature[(radius > 0.5671) & (radius < 0.5729)]) == {"outer shroud"}
    legs = (radius > 0.5731) & (radius < 0.5839)
    assert set(found.feature[legs & (z < 0.1)]) == {"front hook, leg"}
    assert set(found.feature[legs & (z > 0.1)]) == {"rear hook, leg"}
    between = (radius > 0.4325) & (radius < 0.5665)
    assert set(found.feature[between]) == {f"aerofoil {k}" for k in (1, 2, 3, 4)}
    angle = np.degrees(np.arctan2(y, x))[between]
    means = [angle[found.feature[between] == f"aerofoil {k}"].mean() for k in (1, 2, 3, 4)]
    assert means == sorted(means)


def test_root_is_described_with_its_end_and_its_doubt(vane, found):
    radius = np.hypot(*vane.points[:, :2].T)
    aerofoil = np.char.startswith(found.feature, "aerofoil")
    root = np.flatnonzero(found.corner & aerofoil & (np.abs(radius - 0.567) < 1e-6))
    assert len(root) > 40
    place = [found.words(int(node)) for node in root]
    assert all("root at the outer shroud" in each for each in place)
    assert all("sharp" in found.doubt(int(node)) for node in root)
    assert not found.clear[root].any()


def test_areas_tile_the_contact_faces(study, vane):
    at = _places_on(study, vane)
    joint = np.array(at.joint)
    assert at.names[0] == "front hook 1"
    assert at.names[-1] == "interlock 10"
    # Hooks: arcs of 0.9 pitch at r 592 and 584, axially where foot and leg front leave room,
    # z 68 to 82 mm; less the areas of the four tied nodes, one at each band's end or middle.
    whole = 2 * 0.9 * 2 * np.pi / 16 * (0.592 + 0.584) * 0.014
    share = at.area[joint == "hook"].sum() / whole
    assert share == pytest.approx(1 - 4 / (4 * 14), abs=0.03)
    # Interlock: height 22 mm, length 60 mm over the cosine of the slant.
    face = 0.022 * 0.060 / np.cos(np.radians(35))
    assert at.area[joint == "interlock"].sum() == pytest.approx(face, rel=0.01)
    assert np.isnan(at.coefficient).all()
