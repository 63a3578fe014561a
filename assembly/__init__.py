"""Scenes of other people's models: matrices from files, contacts by node lists, to a response."""

from vanelock import lazy

_modules = {
    "Block": "piece",
    "Found": "monitor",
    "Joined": "connect",
    "Piece": "piece",
    "Pull": "connect",
    "Scene": "model",
    "SceneCase": "cases",
    "Tie": "connect",
    "Touching": "connect",
    "check_file": "checking",
    "check_scene": "load",
    "is_scene": "load",
    "load_scene": "load",
    "run_scene": "run",
    "scene_cases": "cases",
    "system_step": "steps",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
