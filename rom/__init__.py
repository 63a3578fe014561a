"""Reduced-order models: Craig-Bampton, cyclic symmetry, Tran, joining components, recovery."""

from vanelock import lazy

_modules = {
    "Component": "component",
    "Excitation": "joining",
    "Joint": "pairs",
    "Recovery": "recover",
    "Reduced": "component",
    "join": "joining",
    "linear_modes": "limits",
    "linear_stiffness": "limits",
    "mac": "limits",
    "recovery": "recover",
    "prepare": "reduction",
    "reduce": "reduction",
    "split": "joining",
    "stiffened": "modulus",
    "united": "uniting",
    "unreduced": "sector",
    "Contacts": "system",
    "Diameter": "system",
    "Force": "system",
    "Faces": "rows",
    "ReducedRows": "rows",
    "Selection": "selection",
    "reduce_rows": "rows",
    "refuse_negative_mass": "massless",
    "reduce_sector": "rows",
    "FrequencyErrors": "accuracy",
    "Neglected": "neglected",
    "frequency_errors": "accuracy",
    "neglected_forms": "accuracy",
    "response_errors": "accuracy",
    "System": "system",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
