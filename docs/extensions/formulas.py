"""Formulas as drawings inside the page: alike everywhere, without a script, a font or a network.

ziamath draws LaTeX with its own mathematical font as SVG paths; Sphinx offers only scripts and
picture files, so its two visitors of a formula are written here.
"""

from html import escape
from typing import Any

import ziamath
from docutils import nodes
from sphinx.util import logging

log = logging.getLogger(__name__)
SIZE = 18
"""Size at which formulas are drawn, px; pages show them in their own."""

ziamath.config.svg2 = False  # paths where they are used: two drawings share no name


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_drawing(node, node.astext(), 1.1))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    drawing = _drawing(node, _lines(node.astext()), 1.15)
    translator.body.append(f'<div class="formula">{drawing}</div>\n')
    raise nodes.SkipNode


def _drawing(node: nodes.Element, text: str, scale: float) -> str:
    """SVG in the text's size, colour and line, with the LaTeX for who cannot see it."""
    try:
        found = ziamath.Latex(text, size=SIZE, color="currentColor", inline=scale < 1.15)
        svg = found.svg()
    except Exception as error:  # whatever the library makes of a mistake in a formula
        log.warning("formula cannot be drawn: %s", error, location=node)
        return ""
    # its box begins above the line by -top and has the line at 0
    box = svg[svg.index("viewBox") :]
    _, top, width, height = (scale * float(each) / SIZE for each in box.split('"')[1].split())
    style = f"width:{width:.3f}em;height:{height:.3f}em;vertical-align:{-top - height:.3f}em"
    label = escape(" ".join(text.split()), quote=True)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{label}" '
        f'class="math" style="{style}" {box}'
    )


def _lines(text: str) -> str:
    r"""Several lines that `\\` ends are aligned at their `&`."""
    own = r"\begin" in text
    return text if own or r"\\" not in text else rf"\begin{{aligned}}{text}\end{{aligned}}"


def setup(app: Any) -> dict[str, bool]:
    """Register the renderer under the name that conf.py chooses."""
    app.add_html_math_renderer("formulas", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
