"""The published study's campaign on any scene: its figures, its statements, where they hold."""

from vanelock import lazy

_modules = {
    "Plane": "plane",
    "Sheet": "sheets",
    "Statement": "statements",
    "run_campaign": "command",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
