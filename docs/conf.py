"""How Sphinx makes the manual from this folder: `make docs` writes build/docs."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "extensions"))

import vanelock

project = "vanelock"
author = "The vanelock developers"
copyright = "2026, the vanelock developers"
version = release = vanelock.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "formulas",
    "stages",
]
exclude_patterns = ["extensions"]
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
highlight_language = "text"

autodoc_default_options = {"members": True}
default_role = "code"
autodoc_member_order = "groupwise"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_preprocess_types = False
python_maximum_signature_line_length = 80

html_theme = "furo"
html_title = f"vanelock {version}"
html_math_renderer = "formulas"
html_static_path = ["static"]
html_css_files = ["manual.css"]
html_show_sphinx = False
html_copy_source = False
