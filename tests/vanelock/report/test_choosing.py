"""Cases to choose from, sections that unfold and ways to look at a plot, in a real browser."""

import numpy as np
import pytest

from vanelock import report

pytestmark = pytest.mark.system

HERTZ = np.linspace(240.0, 260.0, 41)
PLOT = "[...document.querySelectorAll('.plot .area')][{}]._fullLayout"


def resonance(top: float) -> report.Trace:
    return report.Trace(HERTZ, top / (1 + (HERTZ - 250) ** 2), f"peak {top:g}")


def plot(top: float, **options) -> report.Plot:
    return report.Plot(
        [resonance(top)], "frequency (Hz)", "amplitude (µm)", f"Curve {top:g}", **options
    )


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A page whose first section stands open, the second folded; of two cases."""
    zoom = ((248.0, 252.0), (0.5, 44.0))
    cases = [
        report.OfCase(name, (plot(top), report.Text(f"Of {name}.")))
        for name, top in (("μ = 0.3", 30.0), ("μ = 0.15", 60.0))
    ]
    sections = (
        report.Section("Open", (plot(40.0, zoom=zoom, log_y=True), *cases)),
        report.Section("Folded", (report.Text("Inside."), plot(10.0), *cases[1:]), folded=True),
    )
    page = report.Page("Two cases", "today", sections)
    return report.write_page(tmp_path_factory.mktemp("page") / "report.html", page)


@pytest.fixture(scope="module")
def page(visit, path):
    opened = visit(path)
    yield opened
    opened.context.close()


def test_one_case_is_shown_until_another_is_chosen(visit, page):
    chooser = page.locator("#case")
    assert chooser.locator("option").all_inner_texts() == ["μ = 0.3", "μ = 0.15"]
    assert page.locator("text=Of μ = 0.3.").is_visible()
    assert not page.locator("text=Of μ = 0.15.").first.is_visible()
    chooser.select_option("μ = 0.15")
    assert not page.locator("text=Of μ = 0.3.").is_visible()
    assert page.locator("text=Of μ = 0.15.").first.is_visible()
    visit.until(page, f"{PLOT.format(2)}?.yaxis.range[1] > 55")  # drawn now, at its full size
    assert page.evaluate(f"{PLOT.format(2)}.width") > 600
    chooser.select_option("μ = 0.3")


def test_a_folded_section_opens_by_its_heading_and_by_the_contents(visit, page):
    inside = page.locator("text=Inside.")
    assert not inside.is_visible()
    page.locator("#folded summary").click()
    assert inside.is_visible()
    visit.until(page, f"{PLOT.format(3)}?.width > 600")
    page.locator("#folded summary").first.click()
    assert not inside.is_visible()
    page.locator("nav a", has_text="Folded").click()
    visit.until(page, "document.querySelector('#folded details').open")
    assert inside.is_visible()


def test_a_plot_is_zoomed_and_made_linear_by_its_buttons(visit, page):
    near, log = page.locator(".ways button").all()
    assert [near.inner_text(), log.inner_text()] == ["Zoom on the peaks", "Logarithmic"]
    axes = PLOT.format(0)
    assert page.evaluate(f"{axes}.yaxis.type") == "log"
    near.click()
    visit.until(page, f"Math.abs({axes}.xaxis.range[0] - 248) < 1e-6")
    assert page.evaluate(f"{axes}.yaxis.range") == pytest.approx(np.log10([0.5, 44]))
    log.click()
    visit.until(page, f"{axes}.yaxis.type === 'linear'")
    assert page.evaluate(f"{axes}.yaxis.range") == pytest.approx([0, 44])
    near.click()
    visit.until(page, f"{axes}.xaxis.range[0] < 241")
    assert page.evaluate(f"{axes}.xaxis.range[1]") > 259


def test_paper_has_all_cases_and_sections(page):
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    for text in ("Of μ = 0.3.", "Of μ = 0.15.", "Inside."):
        assert all(each.is_visible() for each in page.locator(f"text={text}").all())
    assert page.locator(".plot .main-svg:visible").count() >= 5
    assert not page.locator("#case").is_visible()
    assert not page.locator(".ways").is_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    assert not page.locator("text=Of μ = 0.15.").first.is_visible()


def test_an_address_opens_the_section_that_it_names(visit, page, path):
    opened = "document.querySelector('#folded details').open"
    page.evaluate(f"{opened} = false")
    page.goto(f"{path.as_uri()}#open")
    assert not page.evaluate(opened)
    page.goto(f"{path.as_uri()}#folded")
    visit.until(page, opened)


def test_a_page_of_one_case_has_nothing_to_choose(visit, tmp_path):
    blocks = (report.OfCase("nominal", (report.Text("Of it."),)),)
    page = report.Page("One", "today", (report.Section("All", blocks),))
    opened = visit(report.write_page(tmp_path / "report.html", page))
    assert opened.locator("#case").count() == 0
    assert opened.locator("text=Of it.").is_visible()
    assert opened.locator("text=nominal").count() == 0
    opened.context.close()


def test_a_browser_that_cannot_unpack_says_so(browser, path):
    context = browser.new_context()
    page = context.new_page()
    page.add_init_script("delete window.DecompressionStream")
    page.goto(path.as_uri())
    page.wait_for_timeout(500)
    assert "browser of 2023 or later" in page.locator(".plot .area").first.inner_text()
    context.close()


def test_nothing_was_complained_of(visit):
    assert visit.complaints == []
