"""Reports: plain data to one HTML file with curves to zoom into and shapes that turn."""

from vanelock.common import lazy

_modules = {
    "Answer": "blocks",
    "Answers": "blocks",
    "Block": "blocks",
    "Body": "blocks",
    "Motion": "blocks",
    "OfCase": "blocks",
    "Page": "blocks",
    "Picture": "blocks",
    "Plot": "blocks",
    "Section": "blocks",
    "Text": "blocks",
    "Trace": "blocks",
    "View": "blocks",
    "body_of": "views",
    "curve_plot": "curves",
    "withheld": "blocks",
    "write_page": "writer",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
