"""The solver takes arrays; it must not pull in what makes meshes and pictures."""

import subprocess
import sys


def test_the_solver_loads_neither_meshing_nor_elements_nor_rendering() -> None:
    program = (
        "import sys, vanelock.nonlinear as n\n"
        "[getattr(n, name) for name in n.__all__]\n"
        "print(sorted({'gmsh', 'skfem', 'meshio', 'pyvista', 'vtk', 'vtkmodules', 'sksparse'}"
        " & set(sys.modules)))"
    )
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert shown.stdout.strip() == "[]"
