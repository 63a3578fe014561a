"""Linear elasticity: stiffness, mass, loads at rest, sparse factorisation, linear modes, stress."""

from vanelock.common import lazy

_modules = {
    "Factor": "solvers.factor",
    "Gauge": "stresses.gauges",
    "Interior": "solvers.schur",
    "Material": "material",
    "Model": "model",
    "Modes": "vibration.linear_modes",
    "SingularError": "solvers.singular",
    "assemble": "elements.assembly",
    "backends": "solvers.factor",
    "centrifugal": "loads.body",
    "cyclic_faces": "vibration.cyclic_symmetry",
    "cyclic_transform": "vibration.cyclic_symmetry",
    "eigenpairs": "vibration.linear_modes",
    "excess_by_element": "discretisation",
    "excess_stiffness": "discretisation",
    "factorise": "solvers.factor",
    "free_motion": "vibration.mechanism",
    "free_rows": "stresses.gauges",
    "gauge": "stresses.gauges",
    "hooke": "stresses.strains",
    "modes": "vibration.linear_modes",
    "schur_complement": "solvers.schur",
    "pressure": "loads.pressure",
    "deviators": "stresses.stresses",
    "peak_von_mises": "stresses.stresses",
    "principal_amplitude": "stresses.stresses",
    "strain": "stresses.strains",
    "strain_energy": "stresses.strains",
    "strain_sums": "stresses.strains",
    "stress": "stresses.stresses",
    "thermal": "loads.body",
    "traction": "loads.traction",
    "turned": "stresses.stresses",
    "von_mises": "stresses.stresses",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
