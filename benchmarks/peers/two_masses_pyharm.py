"""The peer's side of `two_masses.py`: pyHarm's two masses, by an interpreter that has it.

python two_masses_pyharm.py INSTANTS result.npz
"""

import sys

import numpy as np
import pyHarm

one = np.ones((1, 1))
mass = {"M": 1.0 * one, "C": 5e-2 * one, "K": 640.0 * one, "G": 0 * one}
damper = {"M": 2e-2 * one, "C": 0 * one, "K": 0 * one, "G": 0 * one}
resonance = np.sqrt(640.0)
inputs = {
    "analysis": {
        "FRF": {
            "study": "frf",
            "puls_inf": resonance - 2.0,
            "puls_sup": resonance + 2.0,
            "ds_max": 5e-3,
            "sign_ds": 1,
            "verbose": False,
            "predictor_options": {"verbose": False, "norm": "om"},
        }
    },
    "system": {"type": "Base", "nh": 5, "nti": int(sys.argv[1])},
    "substructures": {
        "mass": {"matrix": mass, "ndofs": 1},
        "damper": {"matrix": damper, "ndofs": 1},
    },
    "connectors": {
        "loading": {
            "type": "CosinusForcing",
            "connect": {"mass": [0]},
            "dirs": [0],
            "amp": 1.0,
        },
        "link": {
            "type": "LinearSpring",
            "connect": {"mass": [0], "damper": [0]},
            "dirs": [0],
            "k": 40.0,
        },
        "friction": {
            "type": "Jenkins",
            "connect": {"damper": [0]},
            "dirs": [0],
            "mu": 0.5,
            "N0": 1.0,
            "k": 400.0,
            "jac": "analytical",
        },
    },
}
model = pyHarm.Maestro(inputs)
model.operate()
solutions = [each for each in model.nls["FRF"].SolList if each.flag_accepted]
omega = np.array([each.x[-1] for each in solutions])
x = np.array([each.x[model.getIndex("mass", 0, 0)] for each in solutions])

np.savez(sys.argv[2], omega=omega, x=x)
