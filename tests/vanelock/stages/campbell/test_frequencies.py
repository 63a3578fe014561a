"""Lines of a Campbell diagram against the unreduced sector with other moduli, and closed form."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.unreduced import unreduced_segment as unreduced
from vanelock import fem, rom
from vanelock.stages.campbell.frequencies import ModesOverSpeed, grid
from vanelock.stages.parts.segment import Segment

SPEEDS = (0.0, 20000.0)


def factors(speed):
    """Moduli that fall by a third and by a fifth, the first with a bend."""
    return float(np.interp(speed, [0, 12000, 20000], [1.1, 0.95, 0.75])), 1.05 - 1.1e-5 * speed


@pytest.fixture(scope="module")
def over_speed(scene):
    def build(k=1, moduli=factors):
        casing = replace(scene.casing, diameters={k: scene.casing.at(k)})
        system = Segment(scene.joints, 1, force=1.0).join(scene.vane, casing)
        return ModesOverSpeed(system, {"vane": scene.vane, "casing": casing}, k, moduli, SPEEDS)

    return build


@pytest.mark.parametrize("k", [0, 3])
@pytest.mark.parametrize("stuck", [False, True])
def test_modes_at_a_few_speeds_span_those_at_all(scene, over_speed, k, stuck):
    """Against the scaled parts joined anew and all their coordinates."""
    found = over_speed(k)
    for speed in (0.0, 3210.0, 12000.0, 17777.0, 20000.0):
        vane, casing = factors(speed)
        shell = replace(scene.casing, diameters={k: scene.casing.at(k)})
        system = Segment(scene.joints, 1, force=1.0).join(
            rom.stiffened(scene.vane, vane), rom.stiffened(shell, casing)
        )
        closed = None if stuck else ~system.contacts.opens
        expected = rom.linear_modes(system, k, 6, closed)[0]
        np.testing.assert_allclose(found.frequencies(speed, stuck, 6), expected, rtol=1e-9)


@pytest.mark.parametrize("stuck", [False, True])
def test_crossings_are_those_of_the_unreduced_sector(scene, over_speed, stuck):
    """Sparse matrices assembled with the moduli at the crossing meet its line, within 1e-4."""
    order = 4
    met = over_speed().meetings(order, stuck, 2, grid(*SPEEDS, [12000.0]))
    assert [each.mode for each in met] == [0, 1]
    for each in met:
        assert each.frequency == pytest.approx(order * each.speed / 60, rel=1e-12)
        models = []
        for model, factor in zip(
            (scene.vane_model, scene.casing_model), factors(each.speed), strict=True
        ):
            metal = model.material
            models.append(
                fem.assemble(model.part, fem.Material(factor * metal.E, metal.nu, metal.rho))
            )
        joints = scene.joints if stuck else scene.joints[:1]
        omega2, _ = fem.eigenpairs(*unreduced(*models, joints, 1), 3)
        hertz = np.sqrt(omega2) / (2 * np.pi)
        assert each.frequency == pytest.approx(hertz[each.mode], rel=1e-4)


def test_crossings_of_a_scene_with_one_modulus_by_closed_form(scene, over_speed):
    """Without springs f(n) = f √s(n), s linear: EO meets it at a root of (EO n / 60)² = f² s(n)."""
    slope = -2.5e-5

    def both(speed):
        return 1 + slope * speed, 1 + slope * speed

    joints = tuple(replace(each, kn=1e-3, kt=1e-3) for each in scene.joints)  # as good as none
    casing = replace(scene.casing, diameters={1: scene.casing.at(1)})
    system = Segment(joints, 1, force=1.0).join(scene.vane, casing)
    found = ModesOverSpeed(system, {"vane": scene.vane, "casing": casing}, 1, both, SPEEDS)
    f = found.frequencies(0.0, True, 10)
    elastic = 0
    for order in (3, 5, 9):
        for met in found.meetings(order, True, 10, grid(*SPEEDS, [])):
            if f[met.mode] < 1.0:  # the vane as a whole on those springs
                continue
            elastic += 1
            a, square = (order / 60) ** 2, f[met.mode] ** 2
            root = (slope * square + np.sqrt((slope * square) ** 2 + 4 * a * square)) / (2 * a)
            assert met.speed == pytest.approx(root, rel=1e-6)
            assert met.frequency == pytest.approx(order * root / 60, rel=1e-6)
    assert elastic >= 3
