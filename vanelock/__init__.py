"""Friction-damped forced response of turbine stator vane segments.

The physics: `vanelock.mesh`, `vanelock.fem`, `vanelock.rom`, `vanelock.nonlinear`, each importing
only those before it. The program on top of it: what files may say (`input`), steps that are kept
(`pipeline`), what they compute (`stages`, `quantities`), what is shown of it (`render`, `report`,
`results`), and the commands. What a script needs of the program has its name here.
"""

from vanelock.common import lazy

_modules = {
    "cases": "input.cases.sweep",
    "Case": "input.cases.sweep",
    "Outcome": "commands.converge.converge",
    "Run": "commands.stored.run",
    "Scene": "files",
    "Study": "files",
    "check_file": "commands.check.file",
    "check_scene": "files",
    "choose_listener": "pipeline.progress",
    "compare_runs": "commands.compare",
    "converge_study": "commands.converge.converge",
    "fit_study": "commands.fit.fit",
    "optimise_study": "commands.optimise.optimise",
    "is_scene": "files",
    "load": "commands.stored.run",
    "load_component": "results.files.results_file",
    "load_scene": "files",
    "load_study": "files",
    "load_system": "results.files.results_file",
    "mesh_study": "commands.mesh",
    "open_results": "results.files.results_file",
    "parse_study": "files",
    "run": "commands.run.study",
    "run_scene": "commands.run.study",
    "run_study": "commands.run.study",
    "template_text": "commands.installed",
    "write_template": "commands.installed",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules | {"__version__": "common.process"})
