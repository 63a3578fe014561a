"""What ParaView reads from a `.vtu` file, read back by VTK and by meshio."""

import meshio
import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import read_mesh
from vanelock.render import write_vtu
from vanelock.render.scenes import annulus, offscreen


def test_shape_and_sets_come_back(sector, tmp_path):
    part = sector()
    random = np.random.default_rng(2)
    shape = random.standard_normal(part.points.shape) + 1j * random.standard_normal(
        part.points.shape
    )
    path = write_vtu(tmp_path / "shapes" / "casing.vtu", part, shape)
    mesh = offscreen.pyvista().read(path)
    np.testing.assert_array_equal(mesh.points, part.points)
    np.testing.assert_array_equal(mesh.cells.reshape(-1, 11)[:, 1:], part.cells)
    assert set(mesh.celltypes) == {24}  # VTK_QUADRATIC_TETRA
    data = mesh.point_data
    back = data["displacement_real (m)"] + 1j * data["displacement_imag (m)"]
    np.testing.assert_array_equal(back, shape)
    np.testing.assert_array_equal(data["amplitude (m)"], annulus.peak(shape))
    assert np.count_nonzero(data["left"]) == len(part.node_sets["left"])
    places = np.arange(1, len(part.node_sets["left"]) + 1)
    np.testing.assert_array_equal(data["left"][part.node_sets["left"]], places)
    # Straight-sided: its volume is that of four chords of an eighth of the annulus.
    volume = 4 * 0.5 * np.sin(np.pi / 16) * (0.6**2 - 0.5**2) * 0.1
    assert mesh.volume == pytest.approx(volume, rel=1e-9)


def test_phase_is_that_of_the_radial_motion(sector, tmp_path):
    part = sector()
    angle = np.arctan2(part.points[:, 1], part.points[:, 0])
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    shape = radial * np.exp(-1j * angle)[:, None]
    data = meshio.read(write_vtu(tmp_path / "casing.vtu", part, shape)).point_data
    np.testing.assert_allclose(data["phase_radial (deg)"], -np.degrees(angle), atol=1e-12)


def test_our_own_reader_gets_the_sets_back_and_a_shape_of_another_part_is_refused(sector, tmp_path):
    part = sector()
    found = read_mesh(write_vtu(tmp_path / "casing.vtu", part))
    np.testing.assert_array_equal(found.points, part.points)
    np.testing.assert_array_equal(found.cells, part.cells)
    for name, nodes in part.node_sets.items():
        np.testing.assert_array_equal(found.node_sets[name], nodes)
    with pytest.raises(InputError, match=r"casing: shape of \(3, 3\)"):
        write_vtu(tmp_path / "x.vtu", sector(), np.zeros((3, 3), complex))
