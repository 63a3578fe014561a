"""Names that try to be more than text, in a real browser: no script runs, all is shown as it is."""

from pathlib import Path

import numpy as np
import pytest

from tests.vanelock.report.conftest import wave
from vanelock import report
from vanelock.common.tables import Column, Table

pytestmark = pytest.mark.system

NAMES = [
    "</script><script>window.pwned=1</script>",
    '"><img src=x onerror="window.pwned=2">',
    "a & b < c > d \" ' ` &lt; &#60;",
    "javascript:window.pwned=3",
    "one\u2028two\u2029three",
    "%{x} %{fullData.name} <b>bold</b> <a href='javascript:window.pwned=4'>link</a>",
    "</style><svg onload=window.pwned=5>",
    "<!-- <script>",
    "{{7*7}} ${7*7} {% raw %}",
    "\\u003cscript\\u003ewindow.pwned=6",
    "</title></textarea><iframe srcdoc='<script>parent.pwned=7</script>'>",
]


def blocks(name: str, body: report.Body, picture: Path) -> tuple[report.Block, ...]:
    x = np.linspace(1.0, 2.0, 5)
    return (
        report.Text(name),
        report.Answers((report.Answer(name, name, name, "good"),)),
        report.Plot((report.Trace(x, x, name, hover=name),), name, name, name, name),
        Table(name, (Column(name, name), Column("n")), [[name, 1.0]]),
        report.View((body,), (report.Motion(name, 1, (wave(body, 1, 1e-6),), 2.0, name),), name),
        report.Picture(picture, name, name),
    )


@pytest.fixture(scope="module")
def page(visit, sample, bent_block, tmp_path_factory):
    """A page with a section for each name."""
    picture = sample.path.parent / "figures" / "shape.png"
    # One section has all kinds of blocks; a view for every name would take long to draw.
    sections = [
        report.Section(name, blocks(name, bent_block(name), picture)[: 6 if i == 0 else 4])
        for i, name in enumerate(NAMES)
    ]
    path = tmp_path_factory.mktemp("names") / "page.html"
    title = " ".join(NAMES)
    report.write_page(path, report.Page(title, title, sections))
    before = len(visit.complaints)
    opened = visit(path)
    yield opened
    assert visit.complaints[before:] == []
    opened.context.close()


def shown(page, selector):
    return [text.strip() for text in page.locator(selector).all_text_contents()]


def test_no_script_runs_and_names_are_shown_as_they_are(page):
    assert page.evaluate("window.pwned === undefined")
    assert page.locator("iframe, svg[onload], img[onerror]").count() == 0
    assert page.locator("a[href^=javascript]").count() == 0
    titles = shown(page, "main h2, section > h2")
    assert [title.rstrip("#¶ ") for title in titles] == NAMES
    cells = shown(page, "td")
    heads = shown(page, "th")
    for name in NAMES:
        assert name in cells
        assert any(name in head for head in heads)
    assert page.locator("h1").text_content() == " ".join(NAMES)
    for which in (".xtitle", ".ytitle"):
        axes = page.locator(f".plot {which}").all_text_contents()
        for name, axis in zip(NAMES, axes, strict=True):
            assert "".join(axis.split()) == "".join(name.replace("\u2028", "").split()), name
    legends = " ".join(page.locator(".legend, .entries").all_text_contents())
    for name in NAMES:
        assert "".join(name.split()) in "".join(legends.split())


def test_hovering_shows_the_name_alone(page, visit):
    """The library of curves fills in what a template names as %{...}, which a name must not do."""
    plot = page.locator(".plot .area").nth(5)
    plot.scroll_into_view_if_needed()
    plot.evaluate("(p) => Plotly.Fx.hover(p, [{curveNumber: 0, pointNumber: 2}])")
    visit.until(page, "document.querySelectorAll('.hovertext').length > 0")
    text = "".join(page.locator(".hovertext").all_text_contents())
    assert text.startswith(NAMES[5])
