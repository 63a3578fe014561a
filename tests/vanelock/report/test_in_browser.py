"""The page in a real browser: quiet, complete, and every control does what it says."""

import io
from base64 import b64decode
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest
from playwright.sync_api import expect

from vanelock import report
from vanelock.common.cyclic import phase_factor
from vanelock.render.scenes import annulus
from vanelock.report import views


@pytest.fixture(scope="module")
def page(visit, sample):
    """The page at desk width."""
    opened = visit(sample.path)
    yield opened
    opened.context.close()


def drawn_after(page, action=lambda: None):
    """What the canvas holds two frames after something was done."""
    action()
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    address = page.locator("figure.view canvas").evaluate("c => c.toDataURL()")
    return read(b64decode(address.partition(",")[2]))


def control(page, name):
    return page.locator(f"[data-control={name}]")


def slide(page, name, value):
    control(page, name).evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }",
        value,
    )


@pytest.mark.system
def test_every_block_is_there(page):
    assert page.locator("html").get_attribute("lang") == "en"
    assert page.locator("h1").inner_text() == 'Study "A" <b>'
    assert page.locator("nav a").all_inner_texts() == [
        "Answers",
        "Curves & tables",
        "Motion",
        "Motion",
    ]
    targets = [link.get_attribute("href") for link in page.locator("nav a").all()]
    assert len(set(targets)) == 4
    assert all(page.locator(target).count() == 1 for target in targets)
    assert page.locator(".answers li").count() == 2
    assert page.locator("strong", has_text="bold").count() == 1
    assert page.locator("code", has_text="figures/response.csv").count() == 1
    loaded = page.locator(".picture img").evaluate("i => [i.naturalWidth, i.naturalHeight]")
    assert loaded == [1500, 900]
    assert "vanelock 0.1.0" in page.locator("footer").inner_text()
    assert page.evaluate("document.scrollingElement.scrollWidth") <= 1280


@pytest.mark.system
def test_curves_are_the_given_ones(page, sample):
    plot = page.locator(".plot").first
    lines = plot.locator(".scatterlayer .trace .js-line")
    # The gap of four points that are not numbers: that curve is drawn in two pieces.
    assert lines.count() == 4
    assert plot.locator(".scatterlayer .trace .points path").count() == 10
    for i, trace in enumerate(sample.curves.traces):
        x, y = page.evaluate(
            "i => { const t = document.querySelector('.plot .area')._fullData[i];"
            " return [[...t.x], [...t.y].map(v => isNaN(v) ? null : v)]; }",
            i,
        )
        np.testing.assert_allclose(x, trace.x, rtol=1e-6)
        np.testing.assert_allclose(np.array(y, float), trace.y, rtol=1e-6)
    strokes = [line.evaluate("e => e.style.stroke") for line in lines.all()]
    blue, vermilion = "rgb(0, 114, 178)", "rgb(213, 94, 0)"
    assert strokes == [blue, blue, vermilion, vermilion]  # one group, one colour


@pytest.mark.system
def test_legend_hides_and_shows(page):
    plot = page.locator(".plot").first
    entries = plot.locator(".legend button")
    assert entries.all_inner_texts() == ["μ = 0.15 & more", "free", "measured"]
    traces = plot.locator(".scatterlayer .trace")
    expect(traces).to_have_count(4)
    entries.nth(1).press("Enter")  # by the keyboard; a group of two
    assert entries.nth(1).get_attribute("aria-pressed") == "false"
    expect(traces).to_have_count(2)
    entries.nth(1).click()
    expect(traces).to_have_count(4)
    entries.nth(0).dblclick()  # alone
    expect(traces).to_have_count(1)
    entries.nth(0).click(modifiers=["Shift"])  # all again
    expect(traces).to_have_count(4)


@pytest.mark.system
def test_axes_are_logarithmic_and_a_wide_table_scrolls_in_its_own_box(page):
    kinds = page.evaluate(
        "(() => { const l = document.querySelectorAll('.plot .area')[1]._fullLayout;"
        " return [l.xaxis.type, l.yaxis.type]; })()"
    )
    assert kinds == ["log", "log"]
    box = page.locator(".scroll").first.evaluate("b => [b.scrollWidth, b.clientWidth, b.tabIndex]")
    assert box[0] > box[1]
    assert box[2] == 0  # the keyboard reaches it
    flagged = page.locator("tr.bad")
    assert flagged.count() == 1
    assert "not met" in flagged.locator("td").first.text_content()


@pytest.mark.system
def test_ring_is_drawn_and_turns(page):
    page.locator("figure.view").scroll_into_view_if_needed()
    assert page.locator(".missing").is_hidden()
    assert colours(seen(page)) > 300
    still = drawn_after(page)
    share = np.mean(np.any(still < 250, axis=-1))
    assert 0.15 < share < 0.8  # the ring fills its box and leaves white around it
    assert np.array_equal(drawn_after(page), still)  # nothing moves unasked

    box = page.locator("figure.view canvas").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def drag():
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 90, middle[1] + 40, steps=3)
        page.mouse.up()

    turned = drawn_after(page, drag)
    assert np.mean(np.any(turned != still, axis=-1)) > 0.05
    assert np.array_equal(drawn_after(page, control(page, "reset").click), still)
    larger = drawn_after(page, lambda: page.locator("figure.view canvas").press("+"))
    assert np.mean(np.any(larger < 250, axis=-1)) > share
    by_keys = drawn_after(page, lambda: page.locator("figure.view canvas").press("ArrowLeft"))
    assert not np.array_equal(by_keys, larger)
    drawn_after(page, control(page, "reset").click)


@pytest.mark.system
def test_motion_is_played_and_stopped(visit, page):
    still = drawn_after(page)
    control(page, "play").click()
    assert control(page, "play").inner_text() == "Pause"
    before = float(control(page, "phase").input_value())
    visit.until(
        page,
        "before => Math.abs(document.querySelector('[data-control=phase]').value - before) > 20",
        before,
    )
    control(page, "play").click()
    moved = drawn_after(page)
    assert np.mean(np.any(moved != still, axis=-1)) > 0.01
    assert np.array_equal(drawn_after(page), moved)
    slide(page, "phase", 90)
    quarter = drawn_after(page)
    slide(page, "phase", 270)
    assert not np.array_equal(drawn_after(page), quarter)
    assert control(page, "phase").input_value() == "270"


@pytest.mark.system
def test_choices_of_the_view(page):
    whole = drawn_after(page)
    status = page.locator(".status")
    assert "263.4 Hz, nodal diameter 2" in status.inner_text()
    assert "µm" in status.inner_text()
    slide(page, "exaggeration", 0)
    undeformed = drawn_after(page)
    assert not np.array_equal(undeformed, whole)
    slide(page, "phase", 10)
    assert np.array_equal(drawn_after(page), undeformed)  # colours show the amplitude of a cycle
    control(page, "colouring").select_option("instant")
    assert not np.array_equal(drawn_after(page), undeformed)
    control(page, "colouring").select_option("part")
    plain = drawn_after(page)
    assert not page.locator(".bar").is_visible()
    control(page, "colouring").select_option("amplitude")
    control(page, "motion").select_option(label="Mode")
    assert "250.9 Hz, nodal diameter 2, backward wave" in status.inner_text()
    assert page.locator(".bar-label").inner_text() == "amplitude / largest (–)"
    assert page.locator(".bar-scale span").all_inner_texts()[-1] == "1"
    slide(page, "exaggeration", 1)
    assert not np.array_equal(drawn_after(page), plain)
    control(page, "extent").select_option("sector")
    assert not np.array_equal(drawn_after(page), whole)
    control(page, "extent").select_option("ring")
    control(page, "motion").select_option(label="Response")


SHADER = """([scene, bodyNumber, motionNumber, alpha, scale]) => {
  // The page's own vertex shader, run on its own arrays, its results read back.
  const gl = document.createElement("canvas").getContext("webgl2");
  const made = gl.createProgram();
  const stages = [[gl.VERTEX_SHADER, window.vanelockView.vertexShader],
    [gl.FRAGMENT_SHADER, "#version 300 es\\nvoid main() {}"]];
  for (const [kind, source] of stages) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.transformFeedbackVaryings(made, ["position", "value"], gl.INTERLEAVED_ATTRIBS);
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw gl.getProgramInfoLog(made);
  gl.useProgram(made);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const body = scene.bodies[bodyNumber], motion = scene.motions[motionNumber];
  const shape = motion.shapes[bodyNumber];
  const count = bytes(body.points).length / 8;
  for (const [name, text, type] of [["place", body.points, gl.UNSIGNED_SHORT],
      ["re", shape.re, gl.SHORT], ["im", shape.im, gl.SHORT]]) {
    const place = gl.getAttribLocation(made, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, bytes(text), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, type, true, 8, 0);
  }
  const around = gl.getAttribLocation(made, "around");
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  const angles = window.vanelockView.sectorAngles(scene.sectors, motion.diameter);
  gl.bufferData(gl.ARRAY_BUFFER, angles, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(around);
  gl.vertexAttribPointer(around, 4, gl.FLOAT, false, 0, 0);
  gl.vertexAttribDivisor(around, 1);
  const at = (name) => gl.getUniformLocation(made, name);
  const numbers = { unit: motion.unit, largest: motion.largest, scale, radius: 1 };
  for (const [name, number] of Object.entries(numbers)) gl.uniform1f(at(name), number);
  gl.uniform2f(at("alpha"), Math.cos(alpha), Math.sin(alpha));
  gl.uniform3fv(at("low"), body.low);
  gl.uniform3fv(at("span"), body.span);
  const results = gl.createBuffer(), size = 16 * count * scene.sectors;
  gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, results);
  gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, size, gl.STATIC_READ);
  gl.bindBuffer(gl.ARRAY_BUFFER, null);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, results);
  gl.enable(gl.RASTERIZER_DISCARD);
  gl.beginTransformFeedback(gl.POINTS);
  gl.drawArraysInstanced(gl.POINTS, 0, count, scene.sectors);
  gl.endTransformFeedback();
  const values = new Float32Array(size / 4);
  gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, values);
  return [...values];
}"""


@pytest.mark.system
@pytest.mark.parametrize(("body", "motion", "alpha"), [(0, 0, 0.7), (1, 0, -2.0), (0, 1, 2.5)])
def test_graphics_card_moves_the_ring_as_the_pictures_do(page, sample, body, motion, alpha):
    scene = views.scene(sample.page.sections[2].blocks[0])
    given, wave = sample.bodies[body], sample.motions[motion]
    scale = 0.1 / np.abs(wave.shapes[body]).max()
    values = page.evaluate(SHADER, [scene, body, motion, alpha, scale])
    found = np.reshape(values, (given.sectors, -1, 4))
    split, _, _ = views.shaded(given.points, given.triangles)
    shape = wave.shapes[body]
    largest = max(annulus.peak(s).max() for s in wave.shapes)
    for j in range(given.sectors):
        lag = phase_factor(wave.nodal_diameter * j, given.sectors)
        points = given.points + scale * annulus.at(lag * shape, alpha)
        moved = annulus.sector_points(points, j, given.sectors)
        # 16 bits: a body of 0.25 m to 2 µm, a displacement drawn as 0.1 m to 2 µm.
        np.testing.assert_allclose(found[j, :, :3], moved[split], atol=1e-5)
        np.testing.assert_allclose(found[j, :, 3], annulus.peak(shape)[split] / largest, atol=1e-4)


@pytest.mark.system
def test_a_folded_table_opens_when_asked_and_on_paper(page):
    rows, fold = page.locator("details table"), page.locator("details summary")
    assert fold.inner_text() == "Show all 5 rows"
    assert not rows.is_visible()
    fold.click()
    assert rows.is_visible()
    assert rows.locator("tr").last.locator("td").all_inner_texts() == ["key 4", "4"]
    fold.click()
    assert not rows.is_visible()
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert rows.is_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert not rows.is_visible()


@pytest.mark.system
def test_phone_shows_all_without_sideways_scrolling(visit, page):
    page.set_viewport_size({"width": 390, "height": 844})
    visit.until(page, "document.querySelector('.plot .area')._fullLayout.width <= 390")
    assert page.evaluate("document.scrollingElement.scrollWidth") <= 390
    for block in page.locator("figure, .answers, .legend, .controls").all():
        box = block.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
    plot = page.locator(".plot").first
    area, legend = plot.locator(".area").bounding_box(), plot.locator(".legend").bounding_box()
    assert legend["y"] >= area["y"] + area["height"]
    page.set_viewport_size({"width": 1280, "height": 900})
    visit.until(page, "document.querySelector('.plot .area')._fullLayout.width > 390")


@pytest.fixture(scope="module")
def view_alone(sample, tmp_path_factory):
    """A page of the view and nothing else, which opens sooner."""
    page = replace(sample.page, sections=sample.page.sections[2:3])
    return report.write_page(tmp_path_factory.mktemp("view") / "report.html", page)


@pytest.mark.system
def test_motion_plays_by_itself_unless_unwanted(visit, sample, view_alone):
    lively = visit(view_alone, reduced_motion="no-preference")
    still = views.scene(sample.page.sections[2].blocks[0])["motions"][0]["instant"]
    visit.until(
        lively,
        "still => Math.abs(document.querySelector('[data-control=phase]').value - still) > 10",
        np.degrees(still),
    )
    lively.context.close()


@pytest.mark.system
def test_without_webgl_a_message_stands_in(browser, view_alone):
    context = browser.new_context()
    page = context.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(view_alone.as_uri())
    assert "no WebGL 2" in page.locator(".missing").first.inner_text()
    assert not page.locator(".controls").is_visible()
    context.close()


@pytest.mark.system
def test_printed_pages_hold_everything(page, tmp_path):
    data = page.pdf(prefer_css_page_size=True)
    assert data.startswith(b"%PDF")
    assert 3 <= data.count(b"/Type /Page\n") <= 8
    # What paper is given: plots, tables and view within its width, controls gone.
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 688, "height": 970})
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    for block in page.locator(".plot .main-svg, table, .view canvas, .picture img").all():
        box = block.bounding_box()
        assert box["width"] <= 690
        assert box["height"] > 20
    assert not page.locator(".controls").is_visible()
    assert colours(seen(page)) > 300
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": 1280, "height": 900})


@pytest.mark.system
def test_nothing_was_complained_of_or_asked_for(visit):
    """Last in the file: over all that the tests above did."""
    assert visit.complaints == []
    assert visit.requests
    assert [url for url in visit.requests if not url.startswith(("file:", "data:", "blob:"))] == []


def read(picture):
    """(height, width, 3) bytes of a PNG file's content."""
    return np.round(255 * matplotlib.image.imread(io.BytesIO(picture))[..., :3]).astype(np.uint8)


def seen(page):
    """The canvas as it stands on the page."""
    return read(page.locator("figure.view canvas").screenshot())


def colours(picture):
    return len(np.unique(picture.reshape(-1, 3), axis=0))
