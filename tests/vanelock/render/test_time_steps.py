"""A period written for ParaView, as VTK's own reader finds it."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.render import at_instant, write_pvd, write_step
from vanelock.render.scenes import offscreen


def test_times_parts_and_fields_come_back(sector, tmp_path):
    parts = [sector("vane", 0.4, 0.5), sector("casing", 0.5, 0.6)]
    random = np.random.default_rng(4)
    waves = {
        part.name: {
            h: random.standard_normal(part.points.shape)
            + 1j * random.standard_normal(part.points.shape)
            for h in (1, 3)
        }
        for part in parts
    }
    times = [0.0, 1 / 3, 1.0]
    files = []
    for k, time in enumerate(times):
        row = []
        for part in parts:
            u = at_instant(waves[part.name], 2.0 * time)
            fields = {"vibration": u, "size": np.linalg.norm(u, axis=1)}
            row.append(write_step(tmp_path / "steps" / f"{part.name}_{k}.vtu", part, fields))
        files.append(row)
    path = write_pvd(tmp_path / "wave.pvd", times, files)
    assert str(tmp_path) not in path.read_text()
    reader = offscreen.pyvista().get_reader(path)
    assert reader.time_values == times
    for time in times:
        reader.set_active_time_value(time)
        blocks = reader.read()
        assert len(blocks) == 2
        for part, block in zip(parts, blocks, strict=True):
            np.testing.assert_allclose(block.points, part.points, atol=1e-7)
            np.testing.assert_array_equal(block.cells.reshape(-1, 11)[:, 1:], part.cells)
            first, third = waves[part.name][1], waves[part.name][3]
            expected = (
                first.real * np.cos(2 * time) - first.imag * np.sin(2 * time)
                + third.real * np.cos(6 * time) - third.imag * np.sin(6 * time)
            )  # fmt: skip
            np.testing.assert_allclose(block.point_data["vibration"], expected, atol=1e-6)
            size = np.linalg.norm(expected, axis=1)
            np.testing.assert_allclose(block.point_data["size"], size, atol=1e-6)


def test_a_field_of_another_part_is_refused(sector, tmp_path):
    with pytest.raises(InputError, match=r"casing: stress of 3 nodes: the part has \d+"):
        write_step(tmp_path / "a.vtu", sector(), {"stress": np.zeros(3)})
    assert not list(tmp_path.iterdir())
