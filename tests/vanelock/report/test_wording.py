"""Numbers, marked text and names as the page shows them."""

from pathlib import Path

from vanelock.report import wording

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
