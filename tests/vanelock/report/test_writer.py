"""What a page is made of, without a browser: text, pictures, skins; nothing half or foreign."""

import io
import re
from base64 import b64decode
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from vanelock import report
from vanelock.common.errors import InputError
from vanelock.common.tables import Table, heads
from vanelock.report import views, wording, writer


def page_of(*blocks):
    return report.Page("Study", "today", (report.Section("All", blocks),))


def refused(tmp_path, block, match):
    with pytest.raises(InputError, match=match):
        report.write_page(tmp_path / "report.html", page_of(block))
    assert not list(tmp_path.glob("*.html*"))


def test_nothing_is_loaded_from_elsewhere_and_a_page_without_curves_is_small(sample, tmp_path):
    text = sample.path.read_text("utf-8")
    own = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', own) == []
    assert "url(" not in own
    assert "@import" not in own
    assert "default-src 'none'" in own
    assert "<script>alert(1)</script>" not in text
    assert text.count("</script>") == text.count("<script")
    path = report.write_page(tmp_path / "new" / "report.html", page_of(report.Text("Hello.")))
    text = path.read_text("utf-8")
    assert "<p>Hello.</p>" in text
    assert len(text) < 40_000
    assert [file.name for file in path.parent.iterdir()] == ["report.html"]


@pytest.mark.system
def test_example_of_the_documentation_writes_its_page(tmp_path, monkeypatch):
    text = (Path(__file__).parents[3] / "docs" / "report_page.md").read_text("utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "response.csv").write_text("frequency,amplitude\n1,2\n2,5\n3,1\n")
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    written = (tmp_path / "page.html").read_text("utf-8")
    assert all(kind in written for kind in ('class="plot"', 'class="view"', 'class="answers"'))


X = np.arange(3.0)
UNEQUAL = report.Trace(X, np.arange(4.0), "μ = 0.3")
FLAGGED = Table("Contacts", heads("a"), [[1]], flags=["good", "bad"])


@pytest.mark.parametrize(
    ("block", "match"),
    [
        (report.Plot((UNEQUAL,), "x", "y", "Response"), r"Response: μ = 0\.3: x \(3,\)"),
        (Table("Contacts", heads("a", "b"), [[1]]), "Contacts: a row of 1 cells: 2"),
        (FLAGGED, "Contacts: 2 flags: 1"),
        (report.Picture(Path(__file__), "S", ""), "test_writer.py: is neither a PNG nor a GIF"),
        (report.Picture(Path("none.png"), "S", ""), "none.png: cannot be read"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, block, match):
    refused(tmp_path, block, match)


def test_shapes_must_fit_their_bodies(tmp_path, sample):
    motion = sample.motions[0]
    view = report.View(sample.bodies, (motion,), "Motion")
    short = replace(motion, shapes=(motion.shapes[0][:-1], motion.shapes[1]))
    refused(tmp_path, replace(view, motions=(short,)), "Response: shapes of")
    still = replace(motion, shapes=tuple(np.zeros_like(s) for s in motion.shapes))
    refused(tmp_path, replace(view, motions=(still,)), "Response: zero everywhere")
    broken = replace(motion, shapes=tuple(s * np.nan for s in motion.shapes))
    refused(tmp_path, replace(view, motions=(broken,)), "Response: shape holds values")
    rings = (sample.bodies[0], replace(sample.bodies[1], sectors=4))
    refused(tmp_path, replace(view, bodies=rings), r"sectors: given \[9, 4\]: must be equal")
    refused(tmp_path, replace(view, motions=()), "needs a body and a motion")


def test_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="report.html: cannot be written"):
        report.write_page(tmp_path / "file" / "report.html", page_of(report.Text("")))


def volume_inside(body):
    """By Gauss: the place's flow out of a closed skin is three times what it holds."""
    a, b, c = body.points[body.triangles].transpose(1, 0, 2)
    return np.sum(np.cross(b - a, c - a) * (a + b + c)) / 18


def test_body_of_a_part_lies_on_its_skin(coarse):
    for part in coarse:
        body, nodes = report.body_of(part)
        assert np.array_equal(body.points, part.points[nodes])
        assert body.sectors == part.sectors
        assert body.name == part.name
        whole = part.points[part.cells[:, :4]]
        edges = whole[:, 1:] - whole[:, :1]
        assert np.isclose(volume_inside(body), np.linalg.det(edges).sum() / 6, rtol=1e-9)


def test_large_skin_is_thinned_over_its_own_nodes(lattice):
    def plate(place):
        return np.array([0.2, 0.1, 0.004]) * place

    part = lattice((48, 32, 2), plate, "hexahedron")
    whole, every = report.body_of(part)
    body, nodes = report.body_of(part, most=2000)
    assert len(whole.triangles) > 6000
    assert 700 < len(body.triangles) <= 2000
    assert set(nodes) < set(every)
    assert np.array_equal(body.points, part.points[nodes])
    # The plate is thinner than a cell of the grid and keeps its two sides and all its corners.
    assert np.array_equal(body.points.min(axis=0), whole.points.min(axis=0))
    assert np.array_equal(body.points.max(axis=0), whole.points.max(axis=0))
    assert np.isclose(volume_inside(body), 0.2 * 0.1 * 0.004, rtol=0.02)
    assert np.isclose(volume_inside(whole), 0.2 * 0.1 * 0.004, rtol=1e-9)
    assert len(body.outline) > 40


def test_cube_is_crisp_and_its_faces_are_flat():
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), -1).reshape(-1, 3)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    split, numbered, normals = views.shaded(corners.astype(float), triangles)
    assert len(split) == 24  # each corner once for each of its three faces
    assert np.array_equal(split[numbered], triangles)
    outward = corners[split[numbered]].mean(axis=1) - 0.5
    assert np.all(np.einsum("tci,ti->tc", normals[numbered], outward) > 0)
    assert np.array_equal(np.sort(np.abs(normals), axis=1), np.tile([0.0, 0.0, 1.0], (24, 1)))


def test_cylinder_is_smooth_around_and_crisp_at_its_rim():
    count = 24
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.vstack([np.c_[rim, np.zeros(count)], np.c_[rim, np.ones(count)], [[0, 0, 1]]])
    i = np.arange(count)
    j = (i + 1) % count
    side = np.vstack([np.c_[i, j, count + j], np.c_[i, count + j, count + i]])
    lid = np.c_[count + i, count + j, np.full(count, 2 * count)]
    split, _, normals = views.shaded(points, np.vstack([side, lid]))
    assert len(split) == 3 * count + 1
    upright = np.abs(normals[:, 2]) > 0.5
    assert upright.sum() == count + 1
    exact = np.c_[points[split[~upright], :2], np.zeros((~upright).sum())]
    # The triangles about a point are not mirrored, so its mean normal leans by some degrees.
    assert np.all(np.sum(normals[~upright] * exact, axis=1) > np.cos(np.radians(360 / count / 2)))


def opened(uri):
    kind, _, text = uri.partition(";base64,")
    data = b64decode(text)
    return kind, len(data), Image.open(io.BytesIO(data))


def waves(height, width):
    """(height, width, 3) bytes of many colours, smooth as a shaded body."""
    y, x = np.mgrid[:height, :width] / height
    bands = [np.sin(3 * x + 2 * y), np.cos(4 * y - x), np.sin(5 * x * y)]
    return np.round(127 * (1 + np.stack(bands, -1))).astype(np.uint8)


def test_drawing_of_lines_stays_exact(tmp_path):
    pixels = np.full((300, 500, 3), 255, np.uint8)
    x = np.arange(500)
    pixels[(150 + 100 * np.sin(x / 40)).astype(int), x] = [0, 114, 178]
    Image.fromarray(pixels).save(tmp_path / "curve.png", compress_level=1)
    uri, size = writer.embedded(tmp_path / "curve.png")
    kind, weight, picture = opened(uri)
    assert size == (500, 300)
    assert kind == "data:image/webp"
    assert weight < (tmp_path / "curve.png").stat().st_size
    assert np.array_equal(np.asarray(picture.convert("RGB")), pixels)


def test_shaded_picture_looks_the_same(tmp_path):
    pixels = waves(600, 900)
    Image.fromarray(pixels).save(tmp_path / "shape.png")
    kind, weight, picture = opened(writer.embedded(tmp_path / "shape.png")[0])
    assert kind == "data:image/webp"
    assert weight < 0.5 * (tmp_path / "shape.png").stat().st_size
    off = np.abs(np.asarray(picture.convert("RGB"), int) - pixels)
    assert off.mean() < 1.5  # of 255


def test_animation_keeps_its_frames_and_their_time(tmp_path):
    pixels = waves(80, 100)
    frames = [Image.fromarray(np.roll(pixels, 7 * i, 1)).quantize(64) for i in range(6)]
    path = tmp_path / "motion.gif"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=80, loop=0)
    kind, _, picture = opened(writer.embedded(path)[0])
    assert kind == "data:image/webp"
    with Image.open(path) as given:
        for frame, exact in zip(
            ImageSequence.Iterator(picture), ImageSequence.Iterator(given), strict=True
        ):
            assert frame.convert("RGB").tobytes() == exact.convert("RGB").tobytes()
    assert picture.n_frames == 6
    assert picture.info["duration"] == 80
    assert picture.info["loop"] == 0  # for ever


@pytest.mark.parametrize("content", [b"<svg/>", b"\x89PNG\r\n\x1a\n", b""])
def test_what_is_no_picture_is_refused(tmp_path, content):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.png: is neither a PNG nor a GIF picture"):
        writer.embedded(tmp_path / "a.png")


NUMBERS = [
    (0.0, "0"), (0.3, "0.3"), (250.9, "250.9"), (71.84449, "71.84"), (16937.2, "16,940"),
    (999999.0, "1×10⁶"), (1.67e7, "1.67×10⁷"), (0.0004567891, "4.568×10⁻⁴"),
    (0.00123456, "0.001235"), (-5.25, "−5.25"), (9.9996, "10"), (float("nan"), "–"),
    (float("-inf"), "−∞"),
]  # fmt: skip
CELLS = [(None, ""), (True, "yes"), (123456, "123,456"), (-2, "−2"), ("a < b", "a &lt; b")]


def test_numbers_have_four_digits():
    assert [wording.number(value) for value, _ in NUMBERS] == [text for _, text in NUMBERS]
    assert [str(wording.cell(value)) for value, _ in CELLS] == [text for _, text in CELLS]
    assert str(wording.cell(0.5)) == "0.5"


def test_texts_labels_and_files_are_shown_as_a_page_does(tmp_path):
    """Only bold and code are marked, and empty lines part paragraphs."""
    text = "**μ = <0.3>** by `mu * **k**` & <i>more</i> 2 ** 3"
    assert str(wording.marked(text)) == (
        "<strong>μ = &lt;0.3&gt;</strong> by <code>mu * **k**</code>"
        " &amp; &lt;i&gt;more&lt;/i&gt; 2 ** 3"
    )
    assert str(wording.paragraphs("\nOne\nline.\n\n \nTwo {0} %s.\n")) == (
        "<p>One\nline.</p>\n<p>Two {0} %s.</p>"
    )
    assert wording.quantity("amplitude (µm)") == ("amplitude", "µm")
    assert wording.quantity("friction coefficient (–)") == ("friction coefficient", "")
    assert wording.quantity("force t(u)") == ("force t(u)", "")
    assert wording.quantity("points") == ("points", "")
    assert wording.file_text(tmp_path / "figures" / "a.csv", tmp_path) == "figures/a.csv"
    assert wording.file_text(Path("runs/vane/figures/a.csv"), Path("runs/vane")) == "figures/a.csv"
    assert wording.file_text("figures/a.csv", tmp_path) == "figures/a.csv"
    assert wording.file_text(tmp_path / "a.csv", tmp_path / "below") == "a.csv"
