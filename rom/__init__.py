"""Reduced-order models: Craig-Bampton, cyclic symmetry, Tran, joining components, recovery."""

from vanelock.common import lazy

_modules = {
    "Component": "component",
    "Excitation": "joining.vane_and_casing",
    "Joint": "joining.pairs",
    "Recovery": "full_fields.recover",
    "Reduced": "component",
    "join": "joining.vane_and_casing",
    "joined_stiffness": "joining.vane_and_casing",
    "linear_damping": "joining.linear_modes",
    "linear_modes": "joining.linear_modes",
    "linear_stiffness": "joining.linear_modes",
    "mac": "joining.linear_modes",
    "MeshExcess": "joining.mesh_excess",
    "modal_excess": "joining.mesh_excess",
    "recovery": "full_fields.recover",
    "rest_shapes": "joining.mesh_excess",
    "prepare": "reduction",
    "reduce": "reduction",
    "split": "joining.vane_and_casing",
    "stiffened": "modulus",
    "united": "joining.uniting",
    "unreduced": "errors.unreduced_sector",
    "Contacts": "system",
    "Diameter": "system",
    "Force": "system",
    "Faces": "routes.rows",
    "ReducedRows": "routes.rows",
    "Selection": "fixed_interface.selection",
    "reduce_rows": "routes.rows",
    "refuse_negative_mass": "fixed_interface.massless",
    "reduce_sector": "routes.rows",
    "FrequencyErrors": "errors.frequency_errors",
    "Neglected": "errors.neglected",
    "frequency_errors": "errors.frequency_errors",
    "neglected_forms": "errors.frequency_errors",
    "response_errors": "errors.frequency_errors",
    "System": "system",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
