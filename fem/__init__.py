"""Linear elasticity: stiffness and mass, sparse factorisation, linear modes, stress."""

from vanelock import lazy

_modules = {
    "Factor": "factor",
    "Gauge": "gauges",
    "Interior": "schur",
    "Material": "material",
    "Model": "model",
    "Modes": "vibration",
    "SingularError": "singular",
    "assemble": "assembly",
    "backends": "factor",
    "cyclic_faces": "symmetry",
    "cyclic_transform": "symmetry",
    "eigenpairs": "eigen",
    "excess_stiffness": "discretisation",
    "factorise": "factor",
    "free_motion": "mechanism",
    "free_rows": "gauges",
    "gauge": "gauges",
    "hooke": "strains",
    "modes": "vibration",
    "schur_complement": "schur",
    "peak_von_mises": "stresses",
    "principal_amplitude": "stresses",
    "strain": "strains",
    "strain_energy": "strains",
    "strain_sums": "strains",
    "stress": "stresses",
    "turned": "stresses",
    "von_mises": "stresses",
}
__all__ = list(_modules)
__getattr__, __dir__ = lazy.attributes(__name__, _modules)
