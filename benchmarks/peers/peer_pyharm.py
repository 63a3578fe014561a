"""The peer's side of `peer.py`: pyHarm on given matrices, run by an interpreter that has it.

    python peer_pyharm.py problem.npz result.npz

The request is in the first file: K, M, C, force (a cosine on the last coordinate, a sine on the one
before), kt, limit, frequencies (equally spaced, rad/s), where to start (blocks, n), and as JSON the
samples, friction, harmonics and options of the analysis.

Its element `Jenkins` bounds the length of the force in all the directions that it is given: one
element a direction is orthogonal friction, one for both is isotropic.
"""

import contextlib
import io
import json
import sys
import time
from typing import Any

import numpy as np

TRIED = 4  # points on which predictors are compared


def description(given: Any, request: dict[str, Any]) -> dict[str, Any]:
    """Input of pyHarm: one substructure, Jenkins elements at contacts, a force that goes round."""
    nodes, omegas = len(given["K"]) // 2, given["omegas"]
    at, force = {"body": [nodes - 1]}, given["force"]
    cosine = {"connect": at, "dirs": [1], "amp": float(force[-1].real)}
    sine = {"connect": at, "dirs": [0], "amp": float(-force[-2].imag)}
    connectors = {
        "cosine": {"type": "CosinusForcing", **cosine},
        "sine": {"type": "SinusForcing", **sine},
    }
    bounded = [[0, 1]] if request["friction"] == "isotropic" else [[0], [1]]
    for contact, (kt, limit) in enumerate(zip(given["kt"], given["limit"], strict=True)):
        for directions in bounded:
            connectors[f"friction {contact} {directions}"] = {
                "type": "Jenkins",
                "connect": {"body": [contact]},
                "dirs": directions,
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


def solve(given: Any, request: dict[str, Any], count: int) -> tuple[float, list[Any]]:
    """CPU seconds of all points, the model being built, and their solutions."""
    from pyHarm.Maestro import Maestro

    with contextlib.redirect_stdout(io.StringIO()):
        maestro = Maestro(description(given, request))
        analysis = maestro.nls["curve"]
        begin = time.process_time()
        analysis.initialise(given["start"].reshape(-1))
        for index in range(1, count):
            analysis.makeStep(index_insolve=index)
            analysis.purge_jacobians()
        seconds = time.process_time() - begin
    return seconds, analysis.SolList


def cheapest(given: Any, request: dict[str, Any]) -> str:
    """The predictor that takes least on a few points, of those with which all converge."""
    seconds = {}
    for predictor in request["predictors"]:
        spent, solutions = solve(given, {**request, "predictor": predictor}, TRIED)
        found = all(solution.flag_accepted for solution in solutions)
        seconds[predictor] = spent if found else np.inf
    return min(seconds, key=lambda predictor: seconds[predictor])


def main() -> None:
    """Answer the request."""
    given = np.load(sys.argv[1])
    request = json.loads(str(given["request"]))
    samples = request["samples"]
    solve(given, {**request, "samples": 32, "predictor": "tangent"}, 3)  # compiles
    predictor = cheapest(given, {**request, "samples": samples[0]})
    runs = [
        solve(given, {**request, "samples": count, "predictor": predictor}, len(given["omegas"]))
        for count in samples
    ]
    blocks = 2 * len(request["harmonics"])
    np.savez(
        sys.argv[2],
        predictor=predictor,
        seconds=[seconds for seconds, _ in runs],
        accepted=[[bool(each.flag_accepted) for each in found] for _, found in runs],
        omegas=[[each.x[-1] for each in found] for _, found in runs],
        x=[[each.x[:-1].reshape(blocks, -1) for each in found] for _, found in runs],
    )


if __name__ == "__main__":
    main()
