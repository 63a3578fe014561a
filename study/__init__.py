"""Study file, stages and their cache, results file, command line."""

from vanelock import lazy

_modules = {
    "Case": "sweep",
    "Study": "model",
    "cases": "sweep",
    "Outcome": "converge",
    "check_file": "checking",
    "choose_listener": "progress",
    "compare_runs": "compare",
    "converge_study": "converge",
    "fit_study": "fit_command",
    "load_study": "read",
    "load_system": "results",
    "mesh_study": "meshing",
    "open_results": "results",
    "parse_study": "read",
    "read_text": "read",
    "run_study": "run",
    "template_text": "template",
    "write_template": "template",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
