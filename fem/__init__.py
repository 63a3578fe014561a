"""Linear elasticity: stiffness, mass, loads at rest, sparse factorisation, linear modes, stress."""

from vanelock.common import lazy

_modules = {
    "Factor": "solvers.backend",
    "Gauge": "gauges",
    "Interior": "solvers.schur",
    "Material": "model",
    "Model": "model",
    "Modes": "linear_modes",
    "SingularError": "solvers.singular",
    "assemble": "elements",
    "backends": "solvers.factor",
    "centrifugal": "loads",
    "cyclic_faces": "linear_modes",
    "cyclic_transform": "linear_modes",
    "eigenpairs": "linear_modes",
    "excess_by_element": "discretisation",
    "excess_stiffness": "discretisation",
    "factorise": "solvers.factor",
    "free_motion": "solvers.singular",
    "gauge": "gauges",
    "hooke": "stresses",
    "modes": "linear_modes",
    "schur_complement": "solvers.schur",
    "pressure": "loads",
    "deviators": "stresses",
    "peak_von_mises": "stresses",
    "strain": "stresses",
    "strain_sums": "stresses",
    "stress": "stresses",
    "thermal": "loads",
    "traction": "loads",
    "turned": "stresses",
    "von_mises": "stresses",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
