"""The peer's side of `peer.py`: pyHarm on given matrices, run by an interpreter that has it.

    python peer_pyharm.py problem.npz result.npz

The request is in the first file: K, M, C, force (on the last coordinate), kt, limit, frequencies
(equally spaced, rad/s), where to start (blocks, n), and as JSON the samples, harmonics and
options of the analysis.
"""

import contextlib
import io
import json
import sys
import time
from typing import Any

import numpy as np


def description(given: Any, request: dict[str, Any]) -> dict[str, Any]:
    """Input of pyHarm: one substructure, two Jenkins elements a contact, a cosine on one dof."""
    nodes, omegas = len(given["K"]) // 2, given["omegas"]
    connectors = {
        "force": {
            "type": "CosinusForcing",
            "connect": {"body": [nodes - 1]},
            "dirs": [1],
            "amp": float(given["force"][-1]),
        }
    }
    for contact, (kt, limit) in enumerate(zip(given["kt"], given["limit"], strict=True)):
        for direction in (0, 1):
            connectors[f"friction {contact} {direction}"] = {
                "type": "Jenkins",
                "connect": {"body": [contact]},
                "dirs": [direction],
                "mu": 1.0,
                "N0": float(limit),
                "k": float(kt),
                "jac": "analytical",
            }
    analysis = {
        "study": "frf",
        "stepsizer": "constant",
        "stopper": "bounds",
        "corrector": "nocontinuation",
        "preconditioner": "nopreconditioner",
        "predictor": request["predictor"],
        "predictor_options": {"norm": "om", "bifurcation_detect": False, "verbose": False},
        "reductors": [{"type": request["reductor"]}],
        "solver": request["solver"],
        "solver_options": request["solver_options"],
        "ds0": float(omegas[1] - omegas[0]),
        "ds_max": 1e9,
        "ds_min": 1e-9,
        "sign_ds": 1,
        "puls_inf": float(omegas[0]),
        "puls_sup": 1e9,
        "verbose": False,
    }
    matrices = {name: np.array(given[name]) for name in ("K", "M", "C")}
    return {
        "system": {"type": "Base", "nh": request["harmonics"], "nti": request["samples"]},
        "substructures": {"body": {"type": "substructure", "matrix": matrices, "ndofs": 2}},
        "connectors": connectors,
        "analysis": {"curve": analysis},
    }


def solve(given: Any, request: dict[str, Any], count: int) -> tuple[list[float], list[Any]]:
    """CPU seconds of each point after the first, and the solutions of all."""
    from pyHarm.Maestro import Maestro

    with contextlib.redirect_stdout(io.StringIO()):
        maestro = Maestro(description(given, request))
        analysis = maestro.nls["curve"]
        analysis.initialise(given["start"].reshape(-1))
        seconds = []
        for index in range(1, count):
            begin = time.process_time()
            analysis.makeStep(index_insolve=index)
            analysis.purge_jacobians()
            seconds.append(time.process_time() - begin)
    return seconds, analysis.SolList


def main() -> None:
    """Answer the request."""
    given = np.load(sys.argv[1])
    request = json.loads(str(given["request"]))
    solve(given, {**request, "samples": 32}, 2)  # compiles
    seconds, solutions = solve(given, request, len(given["omegas"]))
    blocks = 2 * len(request["harmonics"]) - (0 in request["harmonics"])
    np.savez(
        sys.argv[2],
        seconds=seconds,
        accepted=[bool(solution.flag_accepted) for solution in solutions],
        omegas=[solution.x[-1] for solution in solutions],
        x=[solution.x[:-1].reshape(blocks, -1) for solution in solutions],
        residual=[np.abs(np.asarray(solution.R)[:-1]).max() for solution in solutions],
    )


if __name__ == "__main__":
    main()
