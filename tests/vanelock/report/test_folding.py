"""A folded table in a real browser."""


def test_a_folded_table_opens_when_asked_and_on_paper(visit, sample):
    page = visit(sample.path)
    rows, fold = page.locator("details table"), page.locator("details summary")
    assert fold.inner_text() == "Show all 5 rows"
    assert not rows.is_visible()
    fold.click()
    assert rows.is_visible()
    fold.click()
    assert not rows.is_visible()
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert rows.is_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert not rows.is_visible()
    page.context.close()
