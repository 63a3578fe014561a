"""Formulas as MathML, which browsers draw by themselves: no script, no font and no network.

docutils turns LaTeX into MathML; Sphinx offers only pictures and scripts, so its two visitors of
a formula are written here.
"""

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

told = logging.getLogger(__name__)


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_mathml(node, node.astext()))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    number = ""
    if node.get("number"):
        number = f'<span class="eqno">({node["number"]})</span>'
    formula = _mathml(node, _lines(node.astext()), as_block=True)
    anchor = f' id="equation-{node["label"]}"' if node.get("label") else ""
    translator.body.append(f'<div class="formula"{anchor}>{formula}{number}</div>\n')
    raise nodes.SkipNode


def _mathml(node: nodes.Element, text: str, as_block: bool = False) -> str:
    try:
        return str(tex2mathml(text, as_block=as_block))
    except MathError as error:
        told.warning("formula cannot be drawn: %s", error, location=node)
        return ""


def _lines(text: str) -> str:
    r"""Several lines that `\\` ends are aligned at their `&`."""
    return rf"\begin{{aligned}}{text}\end{{aligned}}" if r"\\" in text and "&" in text else text


def setup(app: Any) -> dict[str, bool]:
    """Register the renderer under the name that conf.py chooses."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
